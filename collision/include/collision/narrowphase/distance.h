#pragma once

#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <array>
#include <cstdint>

namespace atl::collision {

/// The distance of two shapes.
struct Distance {
  static constexpr std::uint32_t no_triangle = ~0u;

  double distance = 0;                   ///< m; of find_distance(), 0 where they overlap: then the rest means little
  Vector3 on_solid = Vector3::Zero();    ///< m, world
  Vector3 on_other = Vector3::Zero();    ///< m, world
  Vector3 normal = Vector3::UnitZ();     ///< unit, from the solid to the other, world
  std::uint32_t triangle = no_triangle;  ///< the closest of a surface, of equal ones the lowest
};

/// Distance of a bounded convex solid (or a point: a sphere of radius 0) from a shape of any kind. False if it is
/// more than `limit` (m, >= 0, may be infinite). The triangles of a surface are plates: they have two sides, and
/// there is nothing behind them.
bool find_distance(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose, double limit,
                   Distance& result);

/// The same where the two are apart. Where they overlap the distance is negative: the least way (m) that the other
/// would have to be moved along the normal, which is found as contacts' are, to 1e-4 of the smaller inner radius (a
/// tenth where a capsule's axis is deep in another solid, or the core of an ellipsoid or a tapered capsule). The points
/// are then the deepest ones. Triangles push solids out by their fronts alone; one that is crossed from behind is
/// touched, with distance 0.
bool find_signed_distance(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose,
                          double limit, Distance& result);

/// True if the two shapes touch or overlap.
bool overlaps(const Shape& solid, const Pose& solid_pose, const Shape& other, const Pose& other_pose);

/// Closest points of two solids that are apart. Where they overlap (or touch) the distance is 0 and the rest
/// is unspecified but finite.
struct ClosestPoints {
  double distance = 0;                ///< m, >= 0
  Vector3 on_first, on_second;        ///< m, frame of the first
  Vector3 normal = Vector3::UnitZ();  ///< unit, from the first to the second
};
ClosestPoints closest_points(const Shape& first_shape, const Shape& second_shape, const Pose& second);
/// The same for a triangle as a two-sided plate; the triangle is the second, in the frame of the first.
ClosestPoints closest_points(const Shape& first_shape, const std::array<Vector3, 3>& triangle);

}  // namespace atl::collision
