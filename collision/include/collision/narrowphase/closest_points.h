#pragma once

#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <array>

namespace atl::collision {

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

}  // namespace atl::collision
