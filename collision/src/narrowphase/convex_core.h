#pragma once

#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace atl::collision {

/// A convex set to which a shape's radius is added: a sphere is a point and a radius, a capsule a segment and a
/// radius, so that distances to them are as exact as those to a point and a segment. A ball of an
/// ellipsoid's least radius of curvature rolls freely in it (Blaschke's rolling theorem), so the ellipsoid is a core
/// and that radius; a tapered capsule has the radius of its smaller ball. All others have no radius.
struct ConvexCore {
  enum class Kind : std::uint8_t { Point, Segment, Box, Cylinder, Cone, Hull, Triangle, Ellipsoid, TaperedCapsule };

  Kind kind = Kind::Point;
  Vector3 half_extents = Vector3::Zero();  ///< box; half axes of the ellipsoid that the core is in, m
  double core_radius = 0;                  ///< of the cylinder, the cone's base, the tapered capsule's lower ball, m
  double top_radius = 0;                   ///< of the tapered capsule's upper ball, m; one of the two is 0
  double half_height = 0;                  ///< of segment, cylinder, cone and tapered capsule, m
  const Hull* hull = nullptr;
  std::array<Vector3, 3> triangle = {};  ///< m
  double radius = 0;                     ///< m, around all of it
  double extent = 0;                     ///< m, bound of the core's points about its origin

  static ConvexCore of(const Shape& shape);
  static ConvexCore of(const std::array<Vector3, 3>& triangle);

  /// The core's farthest point along a direction of any length.
  Vector3 support(const Vector3& direction) const;
};

inline ConvexCore ConvexCore::of(const Shape& shape) {
  ConvexCore core;
  core.half_height = shape.half_height;
  core.core_radius = shape.radius;
  core.extent = shape.bounding_radius;
  switch (shape.kind) {
    case ShapeKind::Capsule:
      core.kind = Kind::Segment;
      core.radius = shape.radius;
      core.extent = shape.half_height;
      break;
    case ShapeKind::Box:
      core.kind = Kind::Box;
      core.half_extents = shape.half_extents;
      break;
    case ShapeKind::Cylinder:
      core.kind = Kind::Cylinder;
      break;
    case ShapeKind::Cone:
      core.kind = Kind::Cone;
      break;
    case ShapeKind::Hull:
      core.kind = Kind::Hull;
      core.hull = shape.hull;
      break;
    case ShapeKind::Ellipsoid:
      core.kind = Kind::Ellipsoid;
      core.half_extents = shape.half_extents;
      core.radius = shape.inner_radius * (shape.inner_radius / shape.bounding_radius);
      core.extent = shape.bounding_radius - core.radius;
      break;
    case ShapeKind::TaperedCapsule:
      core.kind = Kind::TaperedCapsule;
      core.radius = std::min(shape.radius, shape.top_radius);
      core.core_radius = shape.radius - core.radius;
      core.top_radius = shape.top_radius - core.radius;
      core.extent = shape.bounding_radius - core.radius;
      break;
    default:
      core.radius = shape.radius;
      core.extent = 0;
      break;
  }
  return core;
}

inline ConvexCore ConvexCore::of(const std::array<Vector3, 3>& triangle) {
  ConvexCore core;
  core.kind = Kind::Triangle;
  core.triangle = triangle;
  for (const Vector3& vertex : triangle) core.extent = std::max(core.extent, vertex.norm());
  return core;
}

inline Vector3 ConvexCore::support(const Vector3& direction) const {
  const auto signed_as = [](double size, double sign) { return sign < 0 ? -size : size; };
  switch (kind) {
    case Kind::Point:
      return Vector3::Zero();
    case Kind::Segment:
      return {0, 0, signed_as(half_height, direction.z())};
    case Kind::Box:
      return {signed_as(half_extents.x(), direction.x()), signed_as(half_extents.y(), direction.y()),
              signed_as(half_extents.z(), direction.z())};
    case Kind::Cylinder:
    case Kind::Cone: {
      const double across = std::sqrt(direction.x() * direction.x() + direction.y() * direction.y());
      const bool cone = kind == Kind::Cone;
      if (cone && 2 * half_height * direction.z() >= core_radius * across) return {0, 0, half_height};
      const double scale = across > 0 ? core_radius / across : 0;
      return {scale * direction.x(), scale * direction.y(),
              cone ? -half_height : signed_as(half_height, direction.z())};
    }
    case Kind::Hull:
      return hull->vertices[hull->support(direction)];
    case Kind::Triangle: {
      const double x = triangle[0].dot(direction);
      const double y = triangle[1].dot(direction);
      const double z = triangle[2].dot(direction);
      return triangle[x >= y ? (x >= z ? 0 : 2) : (y >= z ? 1 : 2)];
    }
    case Kind::Ellipsoid: {
      const Vector3 stretched = half_extents.cwiseProduct(direction);
      return half_extents.cwiseProduct(stretched.normalized()) - radius * direction.normalized();
    }
    case Kind::TaperedCapsule: {
      const double length = direction.norm();
      const bool top = 2 * half_height * direction.z() >= (core_radius - top_radius) * length;
      const double ball = length > 0 ? (top ? top_radius : core_radius) / length : 0;
      return Vector3(0, 0, top ? half_height : -half_height) + ball * direction;
    }
  }
  return Vector3::Zero();
}

}  // namespace atl::collision
