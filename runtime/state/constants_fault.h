#pragma once

namespace atl {

struct BodyConstants;

/// What no body that was made by a definition has, as messages say it; null if there is nothing: what is in a file need
/// not come of one. Geometry is left out, which files of snapshots don't have.
const char* constants_fault(const BodyConstants& body);

}  // namespace atl
