#pragma once

#include <collision/shapes/hull.h>
#include <collision/shapes/polytope.h>
#include <collision/shapes/pose.h>
#include <collision/shapes/triangle.h>

namespace atl::collision {

/// A solid in the frame of a surface.
struct SurfaceSolid {
  const Shape& shape;
  Vector3 position;  ///< m
  Matrix3 rotation;
  double min_reach;  ///< m: along every direction it reaches as far as that at least; or minus infinity
  Core core;

  SurfaceSolid(const Shape& solid, const Pose& pose)
      : shape(solid), position(pose.position), rotation(pose.orientation.toRotationMatrix()), min_reach(0) {
    if (solid.kind == ShapeKind::Sphere) min_reach = solid.radius;
    if (solid.kind == ShapeKind::Box) min_reach = solid.half_extents.minCoeff();
    if (solid.kind == ShapeKind::Ellipsoid) min_reach = solid.inner_radius;
    if (solid.kind == ShapeKind::TaperedCapsule) min_reach = 0.5 * (solid.radius + solid.top_radius);
    if (solid.kind == ShapeKind::Hull) min_reach = solid.hull->min_reach;
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
  /// The height (m) of the solid over a point along a unit direction; negative if it reaches behind the point.
  double height(const Vector3& direction, const Vector3& from) const {
    return direction.dot(position - from) - reach_along(shape, turned(Vector3(-direction)));
  }
};

/// The direction that parts a solid from a triangle best, of those in which the triangle's surface can push.
struct TriangleAxis {
  enum class Part : std::uint8_t { Face, Edge, Vertex };

  Vector3 normal = Vector3::UnitZ();  ///< unit, from the triangle to the solid, surface's frame
  double separation = 0;              ///< m, along the normal
  Part part = Part::Face;             ///< of the triangle, that meets the solid
  int index = 0;                      ///< of the edge or vertex
  /// The normal of the triangle beyond the edge, which therefore has the contact as its own.
  bool of_neighbour = false;
  /// m, surface's frame: the solid's (or its core's) nearest point, or the ends of its nearest edge.
  int support_count = 0;
  std::array<Vector3, 2> support = {Vector3::Zero(), Vector3::Zero()};
};

/// True if nothing lies beyond an edge.
inline bool is_border(const Triangle& triangle, std::size_t edge) {
  return (triangle.convex_edges >> edge & 1) != 0 && triangle.neighbour_normals[edge] == triangle.normal;
}

/// Looks at the triangle's normal, and, where the solid reaches across a convex edge, at those between it and the
/// neighbour's, up to right angles at a border, and at those of the edge's ends. `height` is the solid's over the
/// triangle's plane.
///
/// Around an edge the separation is piecewise smooth in the angle: a polytope's support vertices are walked
/// through, each with its closed form; those of all that is round about an axis, and of ellipsoids, are searched.
///
/// The search ends at an axis that parts the two by more than `max` (m), which then may not be the best.
TriangleAxis find_triangle_axis(const SurfaceSolid& solid, const Triangle& triangle, double height, double max);

}  // namespace atl::collision
