#pragma once

#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

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

}  // namespace atl::collision
