#pragma once

#include <audit/placed.h>
#include <collision/narrowphase/collide.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>
#include <vector>

#include "support/placing.h"

namespace atl::test {

/// The narrowphase's view of a shape; what it points to belongs to the shape.
inline collision::Shape colliding(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return collision::Shape::sphere(sphere->radius);
  if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    return collision::Shape::capsule(capsule->radius, capsule->half_height);
  }
  if (const auto* box = std::get_if<Box>(&shape)) return collision::Shape::box(box->half_extents);
  if (const auto* solid = std::get_if<Cylinder>(&shape)) {
    return collision::Shape::cylinder(solid->radius, solid->half_height);
  }
  if (const auto* solid = std::get_if<Cone>(&shape)) return collision::Shape::cone(solid->radius, solid->half_height);
  if (const auto* solid = std::get_if<Ellipsoid>(&shape)) return collision::Shape::ellipsoid(solid->half_axes);
  if (const auto* solid = std::get_if<TaperedCapsule>(&shape)) {
    return collision::Shape::tapered_capsule(solid->radii[0], solid->radii[1], solid->half_height);
  }
  if (const auto* hull = std::get_if<ConvexHull>(&shape)) return collision::Shape::convex_hull(*hull->data());
  const auto& ground = std::get<HalfSpace>(shape);
  return collision::Shape::half_space(ground.normal.normalized(), ground.offset);
}

inline double degrees_between(const Vector3& u, const Vector3& v) {
  return std::atan2(u.cross(v).norm(), u.dot(v)) * 180 / std::numbers::pi;
}

/// A shape with a pose, for the narrowphase and for the audit.
struct Posed {
  Shape shape;
  collision::Shape colliding;
  collision::Pose pose;

  audit::Placed placed() const { return audit::place(place(shape, pose.position, pose.orientation)); }
};

inline Posed posed(const Shape& shape) { return {shape, colliding(shape), {Vector3::Zero(), Quaternion::Identity()}}; }

/// A manifold in the world frame.
struct Found {
  Vector3 normal;     ///< world frame, from a to b
  double depth;       ///< m, of the deepest point
  double shallowest;  ///< m, depth of the least deep point
  double outside;     ///< m, by how much a point lies off its shape, or the point opposite off the other
  int count;
  std::vector<Vector3> points;  ///< m
};

/// How far a point of a frame lies outside a shape, m.
inline double distance(const collision::Pose& frame, const Vector3& point, const Posed& shape) {
  const audit::PlacedSolids at = {audit::Solid{frame.position + frame.orientation * point, audit::Polytope::point()}};
  return -audit::penetration(at, shape.placed()).depth;
}

/// Found at the first look, by FCL's axis, or at a later one, by the best from there.
inline Found collide(const Posed& a, const Posed& b, double margin, int looks = 2) {
  collision::Manifold manifold;
  for (int i = 0; i < looks; ++i) {
    manifold = collision::as_last(manifold);
    manifold.axis = 0;
    collision::collide(a.colliding, b.colliding, collision::relative(a.pose, b.pose), margin, manifold);
  }
  Found found{Vector3::Zero(), -INFINITY, INFINITY, 0, manifold.count, {}};
  const Posed& reference = manifold.reference_is_second ? b : a;
  found.normal = (manifold.reference_is_second ? -1 : 1) * (reference.pose.orientation * manifold.normal);
  const Posed& incident = manifold.reference_is_second ? a : b;
  for (int i = 0; i < manifold.count; ++i) {
    const auto& point = manifold.points[static_cast<std::size_t>(i)];
    found.points.push_back(reference.pose.position + reference.pose.orientation * point.position);
    found.depth = std::max(found.depth, -point.separation);
    found.shallowest = std::min(found.shallowest, -point.separation);
    const Vector3 opposite = point.position - point.separation * manifold.normal;
    found.outside = std::max({found.outside, distance(reference.pose, point.position, incident),
                              distance(reference.pose, opposite, reference)});
  }
  return found;
}

}  // namespace atl::test
