#pragma once

#include "narrowphase/convex_core.h"

namespace atl::collision {

/// Tells if closest_point() has a closed form for a core: all but those of hulls, ellipsoids and tapered capsules.
inline bool has_closest_point(const ConvexCore& core) {
  using enum ConvexCore::Kind;
  return core.kind != Hull && core.kind != Ellipsoid && core.kind != TaperedCapsule;
}

/// The point of a core (without its radius) that is closest to a point: the point itself if it is inside.
Vector3 closest_point(const ConvexCore& core, const Vector3& point);

/// The point of a triangle that is closest to a point.
Vector3 closest_point_of_triangle(const std::array<Vector3, 3>& triangle, const Vector3& point);

}  // namespace atl::collision
