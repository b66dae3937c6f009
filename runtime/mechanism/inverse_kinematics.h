#pragma once

#include <optional>

#include "mechanism/kinematics.h"

namespace atl::mechanism {

/// The place to which a point of a link is to be brought, and maybe the orientation of its body.
struct Target {
  std::size_t link;
  Vector3 point;     ///< m, body frame
  Vector3 position;  ///< m, world frame, of the point
  std::optional<Quaternion> orientation;
};

/// See Mechanism::inverse_kinematics().
InverseKinematics inverse_kinematics(const Tree& tree, const World& world, const Target& target);

}  // namespace atl::mechanism
