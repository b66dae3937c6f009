#pragma once

#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>

namespace atl::collision {

/// A point against a solid's surface: outward unit normal there, and distance (m), negative inside.
struct SurfaceDistance {
  Vector3 normal;
  double distance;
};

/// Exact, outside and inside. The point is in the shape's frame.
SurfaceDistance distance_to_surface(const Shape& shape, const Vector3& point);

/// A sphere, the first shape, against any solid. Exact, whether the centre is outside or inside.
void collide_sphere_solid(double radius, const Shape& solid, const Pose& second, double margin, Manifold& manifold);

}  // namespace atl::collision
