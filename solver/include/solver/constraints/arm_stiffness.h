#pragma once

#include <solver/integrate/body_table.h>

namespace atl::solver {

/// N m, world frame: how a body that a force pulls on at an arm from its centre resists turning, as long as the force
/// stays what it is: r.F (1 - r r^T / r^2), the geometric stiffness where the two are parallel (Tournier, Nesme, Gilles
/// and Faure, "Stable constrained dynamics", SIGGRAPH 2015). A force that pushes has a negative one, which is left out.
///
/// A light body under high tension swings faster than substeps can follow. With h^2 times its stiffness counted as
/// inertia it turns back by no more than a radian a substep, which is what leapfrogs stand (Hairer, Lubich and Wanner,
/// "Geometric Numerical Integration", 2006, I.5), at any tension and without damping.
inline Matrix3 arm_stiffness(const Vector3& arm, const Vector3& force) {
  const double tension = arm.dot(force);
  if (!(tension > 0)) return Matrix3::Zero();
  const double part = tension / arm.squaredNorm();
  Matrix3 stiffness;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) stiffness(i, k) = (i == k ? tension : 0) - part * arm[i] * arm[k];
  }
  return stiffness;
}

}  // namespace atl::solver
