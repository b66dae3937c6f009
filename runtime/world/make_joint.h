#pragma once

#include <atoll/joint.h>
#include <solver/constraints/joint.h>

#include <cstddef>
#include <span>

namespace atl {

/// Makes the coordinates of a joint kind and the laws that they obey. Frames and bodies are left open.
solver::Joint make_joint(const JointKind& kind);

/// The whole of a joint but for its bodies, whose centres of mass are given in their frames, m. Unit orientations.
solver::Joint make_joint(const JointDef& def, const Vector3& centre_first, const Vector3& centre_second);

/// The coordinates that JointState tells of, in order.
std::span<const solver::Coordinate> named_coordinates(const JointKind& kind);
/// The law of one coordinate, by its number; nullptr if there is none.
JointAxis* named_axis(JointKind& kind, std::size_t coordinate);
const JointAxis* named_axis(const JointKind& kind, std::size_t coordinate);

}  // namespace atl
