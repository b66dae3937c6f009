#include "joining.h"

#include <cmath>

namespace atl::scene {

Pose seen_from(const BodyDef& body, const Pose& world) {
  const Quaternion back = body.orientation.normalized().conjugate();
  return {back * (world.position - body.position), (back * world.orientation).normalized()};
}

Quaternion frame_along(const Vector3& x, const Vector3& towards_y) {
  Matrix3 axes;
  axes.col(0) = x.normalized();
  axes.col(2) = axes.col(0).cross(towards_y.normalized()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return Quaternion(axes).normalized();
}

Quaternion frame_along(const Vector3& x) {
  const Vector3 unit = x.normalized();
  constexpr double nearly_upright = 0.9;  // of the z component
  return frame_along(x, std::abs(unit.z()) < nearly_upright ? Vector3::UnitZ() : Vector3::UnitX());
}

SceneJoint joined(const Scene& scene, std::string name, const JointKind& kind, std::size_t first, std::size_t second,
                  const Pose& frame) {
  SceneJoint joint;
  joint.name = std::move(name);
  joint.first = first;
  joint.second = second;
  joint.def.kind = kind;
  joint.def.frame_first = seen_from(scene.bodies.at(first).def, frame);
  joint.def.frame_second = seen_from(scene.bodies.at(second).def, frame);
  return joint;
}

}  // namespace atl::scene
