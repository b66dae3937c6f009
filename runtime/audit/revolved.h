#pragma once
/// Cylinders and cones as the audit tests them.

#include <atoll/types.h>

#include <algorithm>
#include <cmath>

namespace atl::audit {

/// A cylinder or a cone about a point half way up its axis, in world axes.
struct Revolved {
  Vector3 axis;  ///< unit, towards a cone's apex
  double radius;
  double half_height;
  bool is_cone;

  /// axis . n of the normals n of the side, and the radial part of such a normal.
  double side_sine() const { return is_cone ? radius / std::hypot(radius, 2 * half_height) : 0; }
  double side_cosine() const { return is_cone ? 2 * half_height / std::hypot(radius, 2 * half_height) : 1; }
};

/// How far the solid reaches along a unit direction, m.
inline double reach(const Revolved& solid, const Vector3& direction) {
  const double along = solid.axis.dot(direction);
  const double across = (direction - along * solid.axis).norm();  // exact near the poles, where 1 - along^2 is not
  if (!solid.is_cone) return solid.radius * across + solid.half_height * std::abs(along);
  return std::max(solid.half_height * along, solid.radius * across - solid.half_height * along);
}

/// Exact signed distance of a point (m, from the solid's own point; negative inside: to the nearest of the surface)
/// and its gradient, a unit vector away from the nearest point of the surface.
struct SignedDistance {
  double distance;
  Vector3 gradient;
};
SignedDistance signed_distance(const Revolved& solid, const Vector3& point);

}  // namespace atl::audit
