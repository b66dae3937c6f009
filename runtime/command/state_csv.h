#pragma once

#include <atoll/scene.h>
#include <atoll/world.h>

#include <iosfwd>
#include <vector>

namespace atl::command {

/// A copy of all bodies' poses and velocities, columns by body index as in the world's bulk views.
class BodyStates {
 public:
  void copy(const World& world);

  /// id,name,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz: SI units, 17 significant digits, a row a body in
  /// the scene's order; the id is the place in that order.
  void write_csv(std::ostream& out, const Scene& scene, const std::vector<BodyId>& ids) const;

 private:
  Eigen::Matrix3Xd positions_;
  Eigen::Matrix4Xd orientations_;
  Eigen::Matrix3Xd velocities_;
  Eigen::Matrix3Xd angular_velocities_;
};

}  // namespace atl::command
