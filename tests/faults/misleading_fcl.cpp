#include "misleading_fcl.h"

#include <collision/narrowphase/fcl_narrowphase.h>

#include <Eigen/Geometry>

namespace atl::test {
namespace {

Fcl fcl = Fcl::Turned;

}  // namespace

void let_fcl_be(Fcl fault) { fcl = fault; }

}  // namespace atl::test

// These stand before the library's own, which the linker has no need of then.
namespace atl::collision::fcl_narrowphase {
namespace {

bool answer(const Vector3& towards, Axis& axis) {
  if (test::fcl == test::Fcl::Silent) return false;
  const Vector3 direction = towards.norm() > 0 ? Vector3(towards.normalized()) : Vector3::UnitZ();
  axis.normal = Eigen::AngleAxisd(1, direction.unitOrthogonal()) * direction;
  axis.separation = -0.1;
  axis.code = 1;
  return true;
}

}  // namespace

bool box_box(const Vector3&, const Vector3&, const Vector3& position, const Matrix3&, double, Axis& axis) {
  return answer(position, axis);
}
bool sphere_sphere(double, double, const Vector3& position, double, Axis& axis) { return answer(position, axis); }
bool sphere_box(double, const Vector3&, const Vector3& centre, double, Axis& axis) { return answer(-centre, axis); }
bool convex(const Shape&, const Shape&, const Vector3& position, const Matrix3&, double, Axis& axis) {
  return answer(position, axis);
}

}  // namespace atl::collision::fcl_narrowphase
