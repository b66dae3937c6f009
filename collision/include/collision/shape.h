#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace atl::collision {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// In the order that pairs are dispatched in: of two shapes the one of the lower kind comes first.
enum class ShapeKind : std::uint8_t { Sphere, Box, HalfSpace };

/// A convex shape in its body's frame. Which fields count depends on the kind.
struct Shape {
  ShapeKind kind = ShapeKind::Box;
  Vector3 half_extents = Vector3::Zero();  ///< box, m
  double radius = 0;                       ///< sphere, m
  Vector3 normal = Vector3::UnitZ();       ///< half-space: solid where normal . p <= offset
  double offset = 0;                       ///< half-space, m
  double bounding_radius = 0;              ///< m, about the body's origin; infinite for half-spaces
  double inner_radius = 0;                 ///< m, of the largest inscribed sphere; infinite for half-spaces

  static Shape sphere(double radius);
  static Shape box(const Vector3& half_extents);
  static Shape half_space(const Vector3& unit_normal, double offset);
};

/// m^3; infinite for half-spaces.
double volume(const Shape& shape);

/// Inertia of the shape about its centre of mass per kg of mass, body frame, in m^2.
Matrix3 unit_inertia(const Shape& shape);

}  // namespace atl::collision
