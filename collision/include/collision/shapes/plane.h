#pragma once

#include <collision/shapes/aabb.h>

#include <cmath>

namespace atl::collision {

/// Solid where normal . p <= offset, in the world frame; the normal of unit length.
struct Plane {
  Vector3 normal;
  double offset;
};

/// True if a box reaches into the half-space. Computed in double, since the plane may be far from the world's origin.
/// For a box with a NaN either answer is possible: its other numbers decide if they can.
inline bool touches(const Plane& plane, const Aabb& box) {
  double lowest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double n = plane.normal[static_cast<Eigen::Index>(i)];
    if (n != 0) lowest += n * static_cast<double>(n > 0 ? box.lower[i] : box.upper[i]);  // 0 times infinity is NaN
  }
  return lowest <= plane.offset;
}

/// True if a box of these half extents, whose centre moves along origin + t * direction, touches the half-space at a t
/// of [0, max_t]. If so, t_enter is the least such t, at most a few roundings too low.
inline bool enters(const Plane& plane, const Vector3& origin, const Vector3& direction, double max_t,
                   const Vector3& half_extents, double& t_enter) {
  constexpr double rounding = 0x1p-49;  // more than a sum of seven products gathers
  const Vector3 size = plane.normal.cwiseAbs();
  const double scale = size.dot(origin.cwiseAbs() + half_extents) + std::abs(plane.offset);
  const double height = plane.normal.dot(origin) - size.dot(half_extents) - plane.offset - rounding * scale;
  const double descent = -plane.normal.dot(direction) + rounding * size.dot(direction.cwiseAbs());
  t_enter = height <= 0 ? 0 : height / descent * (1 - rounding);
  return height <= 0 ? max_t >= 0 : descent > 0 && t_enter <= max_t;
}

}  // namespace atl::collision
