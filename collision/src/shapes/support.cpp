#include <collision/shapes/hull.h>
#include <collision/shapes/pose.h>

#include <cmath>
#include <limits>

namespace atl::collision {
namespace {

// A disc of the given radius about z, at a height.
Vector3 disc_support(double radius, double height, const Vector3& direction) {
  const double across = std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
  const double scale = across > 0 ? radius / across : 0;
  return {scale * direction.x(), scale * direction.y(), height};
}

double with_sign(double size, double sign) { return sign < 0 ? -size : size; }

}  // namespace

Vector3 support_point(const Shape& shape, const Vector3& direction) {
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return shape.radius * direction.normalized();
    case ShapeKind::Capsule: {
      const Vector3 cap(0, 0, with_sign(shape.half_height, direction.z()));
      return cap + shape.radius * direction.normalized();
    }
    case ShapeKind::Box: {
      const Vector3& half = shape.half_extents;
      return {with_sign(half.x(), direction.x()), with_sign(half.y(), direction.y()),
              with_sign(half.z(), direction.z())};
    }
    case ShapeKind::Cylinder:
      return disc_support(shape.radius, with_sign(shape.half_height, direction.z()), direction);
    case ShapeKind::Cone: {
      const double apex = shape.half_height * direction.z();
      const double across = std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
      const double rim = shape.radius * across - apex;
      return apex >= rim ? Vector3(0, 0, shape.half_height) : disc_support(shape.radius, -shape.half_height, direction);
    }
    case ShapeKind::Hull:
      return shape.hull->vertices[shape.hull->support(direction)];
    case ShapeKind::Ellipsoid: {
      const Vector3 stretched = shape.half_extents.cwiseProduct(direction);
      return shape.half_extents.cwiseProduct(stretched.normalized());
    }
    case ShapeKind::TaperedCapsule: {
      const double across = (shape.radius - shape.top_radius) * direction.norm();
      const bool top = 2 * shape.half_height * direction.z() >= across;
      return Vector3(0, 0, top ? shape.half_height : -shape.half_height) +
             (top ? shape.top_radius : shape.radius) * direction.normalized();
    }
    case ShapeKind::HalfSpace:
    case ShapeKind::Mesh:
    case ShapeKind::HeightField:
      break;
  }
  return Vector3::Zero();
}

double reach_along(const Shape& shape, const Vector3& unit_direction) {
  if (shape.kind == ShapeKind::Box) return unit_direction.cwiseAbs().dot(shape.half_extents);
  if (shape.kind == ShapeKind::Hull) return shape.hull->reach(unit_direction);
  return support_point(shape, unit_direction).dot(unit_direction);
}

CentreLine centre_line(const Shape& first, const Pose& at_first, const Shape& second, const Pose& at_second) {
  const Vector3 between = at_second.position - at_first.position;
  const double distance = between.norm();
  if (!(distance > 0)) return {Vector3::Zero(), -std::numeric_limits<double>::infinity()};
  const Vector3 direction = between / distance;
  return {direction, distance - reach_along(first, at_first.orientation.conjugate() * direction) -
                         reach_along(second, -(at_second.orientation.conjugate() * direction))};
}

}  // namespace atl::collision
