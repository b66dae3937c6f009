#pragma once

#include <collision/narrowphase/manifold.h>
#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <array>

namespace atl::collision {

// What all bounded convex solids (Sphere to Hull) have in common. `second` is always the pose of the second
// shape in the frame of the first.

/// The point of the solid that lies farthest along a direction (any length, not zero), shape's frame.
Vector3 support_point(const Shape& shape, const Vector3& direction);

/// How far the solid reaches along a unit direction: support_point . direction.
double reach_along(const Shape& shape, const Vector3& unit_direction);

/// What the planes across the line of their centres tell of two solids, cheap enough to ask before anything else.
struct CentreLine {
  Vector3 direction;  ///< unit, from the first centre to the second; zero where they coincide
  double gap;         ///< m, a lower bound of the distance; minus infinity where they coincide
};
CentreLine centre_line(const Shape& first, const Pose& at_first, const Shape& second, const Pose& at_second);

/// Closest points of two solids that are apart. Where they overlap (or touch) the distance is 0 and the rest
/// is unspecified but finite.
struct ClosestPoints {
  double distance = 0;                ///< m, >= 0
  Vector3 on_first, on_second;        ///< m, frame of the first
  Vector3 normal = Vector3::UnitZ();  ///< unit, from the first to the second
};
ClosestPoints closest_points(const Shape& first_shape, const Shape& second_shape, const Pose& second);
/// Against a triangle as a two-sided plate; the triangle is the second, in the frame of the first.
ClosestPoints closest_points(const Shape& first_shape, const std::array<Vector3, 3>& triangle);

/// Contact points of two solids: see collide().
Narrowphase collide_convex(const Shape& first_shape, const Shape& second_shape, const Pose& second, double margin,
                           Manifold& manifold);

/// Contact points of a solid with a half-space, given in the frame of the solid by `second`.
void collide_half_space(const Shape& solid_shape, const Shape& half_space, const Pose& second, double margin,
                        Manifold& manifold);

}  // namespace atl::collision
