#include <collision/aabb.h>

#include <cmath>

namespace atl::collision {
namespace {

float round_down(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded <= value ? rounded : std::nextafter(rounded, -std::numeric_limits<float>::infinity());
}

float round_up(double value) {
  const auto rounded = static_cast<float>(value);
  return rounded >= value ? rounded : std::nextafter(rounded, std::numeric_limits<float>::infinity());
}

}  // namespace

Aabb Aabb::around(const Vector3& lower, const Vector3& upper) {
  return {{round_down(lower.x()), round_down(lower.y()), round_down(lower.z())},
          {round_up(upper.x()), round_up(upper.y()), round_up(upper.z())}};
}

Bounds bounds_of(const Shape& shape, const Vector3& position, const Matrix3& rotation) {
  Vector3 half = Vector3::Constant(shape.radius);
  if (shape.kind == ShapeKind::Box) half = rotation.cwiseAbs() * shape.half_extents;
  return {position - half, position + half};
}

}  // namespace atl::collision
