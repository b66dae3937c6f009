#pragma once

#include <collision/shapes/convex.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/polytope.h>

namespace atl::collision {

/// A solid in the frame of a surface.
struct SurfaceSolid {
  const Shape& shape;
  Vector3 position;  ///< m
  Matrix3 rotation;
  double least_reach;  ///< m: along every direction it reaches as far as that at least; or minus infinity
  Core core;

  SurfaceSolid(const Shape& solid, const Pose& pose)
      : shape(solid), position(pose.position), rotation(pose.orientation.toRotationMatrix()), least_reach(0) {
    if (solid.kind == ShapeKind::Sphere) least_reach = solid.radius;
    if (solid.kind == ShapeKind::Box) least_reach = solid.half_extents.minCoeff();
    if (solid.kind == ShapeKind::Hull) least_reach = solid.hull->least_reach;
    core.build(solid);
  }

  Vector3 turned(const Vector3& direction) const { return rotation.transpose() * direction; }
  Vector3 seen(const Vector3& point) const { return rotation.transpose() * (point - position); }
  Vector3 placed(const Vector3& point) const { return position + rotation * point; }

  /// The farthest point along a unit direction, and how far that is (m) from a point.
  Vector3 support(const Vector3& direction) const { return placed(support_point(shape, turned(direction))); }
  double reach(const Vector3& direction, const Vector3& from) const {
    return direction.dot(position - from) + reach_along(shape, turned(direction));
  }
  /// How far (m) the solid is from a point along a unit direction; negative where it reaches behind it.
  double height(const Vector3& direction, const Vector3& from) const {
    return direction.dot(position - from) - reach_along(shape, turned(Vector3(-direction)));
  }
};

}  // namespace atl::collision
