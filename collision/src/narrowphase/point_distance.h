#pragma once

#include "narrowphase/convex_core.h"

namespace atl::collision {

/// Whether closest_point() has a closed form for a core: all but a hull's.
inline bool has_closest_point(const ConvexCore& core) { return core.kind != ConvexCore::Kind::Hull; }

/// The point of a core (without its radius) that is closest to a point: the point itself if it is inside.
Vector3 closest_point(const ConvexCore& core, const Vector3& point);

/// The point of a triangle that is closest to a point.
Vector3 closest_point_of_triangle(const std::array<Vector3, 3>& triangle, const Vector3& point);

}  // namespace atl::collision
