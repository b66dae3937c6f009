#pragma once
/// Tendons: what of them follows from the joints of their terms.

#include <atoll/joint.h>
#include <solver/constraints/joint.h>

#include "world/stores.h"

namespace atl {

/// A definition with the bodies of the first of its joints, if it is a tendon. Throws Error for terms that none can
/// have.
JointDef with_bodies(const Stores& world, JointDef def);

/// Tells a tendon which coordinates its terms are of; those that it had before, as `before`, keep their positions.
/// Throws Error as with_bodies() does.
void bind_tendon(const Stores& world, const JointKind& kind, const solver::Joint& before, solver::Joint& joint);

/// Finds where a tendon's coordinates are. Angles start with the turns that their joints count.
void find_length(const Stores& world, solver::Joint& tendon);
/// Once bodies have been put elsewhere.
void follow_length(const Stores& world, solver::Joint& tendon);

}  // namespace atl
