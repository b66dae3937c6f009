#pragma once

#include <atoll/joint.h>

namespace atl {

/// The definition with unit orientations. Throws Error naming the field, the value and what was expected. What depends
/// on the bodies is not looked at.
JointDef checked(const JointDef& def);

/// Throws likewise; `what` names the argument.
void check(const char* what, const JointKind& kind);

/// "BallJoint", ...
const char* name_of(const JointKind& kind);

}  // namespace atl
