#pragma once
/// The errors of a build without a capability (runtime/package/features.cmake).

#include <atoll/types.h>

namespace atl {

struct BodyConstants;

/// Throws Error: `asked` says what call or value asks for what this build is without, `option` is ATOLL_WITH_...
[[noreturn]] void throw_left_out(const char* asked, const char* what, const char* option);

/// Throws Error if a body calls for what this build is without.
void check_built_for(const BodyConstants& body);
/// Or if a surface does that runs so fast; `what` names that.
void check_built_for_surface(const char* what, const Vector3& velocity);

}  // namespace atl
