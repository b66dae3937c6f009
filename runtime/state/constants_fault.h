#pragma once

namespace atl {

struct BodyConstants;

/// Describes a property that no body made by a definition can have, in a message's words; null if there is none. A file
/// may be damaged or forged, so its bodies need not come from a definition. Geometry is left out: files of snapshots
/// don't have it.
const char* constants_fault(const BodyConstants& body);

}  // namespace atl
