#include <collision/shape.h>

#include <limits>
#include <numbers>

namespace atl::collision {

Shape Shape::sphere(double radius) {
  Shape shape;
  shape.kind = ShapeKind::Sphere;
  shape.radius = radius;
  shape.bounding_radius = radius;
  shape.inner_radius = radius;
  return shape;
}

Shape Shape::box(const Vector3& half_extents) {
  Shape shape;
  shape.kind = ShapeKind::Box;
  shape.half_extents = half_extents;
  shape.bounding_radius = half_extents.norm();
  shape.inner_radius = half_extents.minCoeff();
  return shape;
}

Shape Shape::half_space(const Vector3& unit_normal, double offset) {
  Shape shape;
  shape.kind = ShapeKind::HalfSpace;
  shape.normal = unit_normal;
  shape.offset = offset;
  shape.bounding_radius = std::numeric_limits<double>::infinity();
  shape.inner_radius = std::numeric_limits<double>::infinity();
  return shape;
}

double volume(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return 4.0 / 3.0 * std::numbers::pi * shape.radius * shape.radius * shape.radius;
    case ShapeKind::Box:
      return 8 * shape.half_extents.prod();
    case ShapeKind::HalfSpace:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

Matrix3 unit_inertia(const Shape& shape) {
  switch (shape.kind) {
    case ShapeKind::Sphere:
      return Matrix3::Identity() * (0.4 * shape.radius * shape.radius);
    case ShapeKind::Box: {
      const Vector3 square = shape.half_extents.cwiseAbs2();
      return (Vector3::Constant(square.sum()) - square).asDiagonal().toDenseMatrix() / 3;
    }
    case ShapeKind::HalfSpace:
      break;
  }
  return Matrix3::Identity() * std::numeric_limits<double>::infinity();
}

}  // namespace atl::collision
