#pragma once
/// Ellipsoids and tapered capsules as the audit tests them.

#include <atoll/types.h>

#include <array>

namespace atl::audit {

/// An ellipsoid, or the convex hull of two balls, in world axes about a point of its own.
struct Smooth {
  Matrix3 half_axes = Matrix3::Zero();       ///< m, columns; of an ellipsoid, else zero
  Vector3 half = Vector3::Zero();            ///< m: the balls' middles are at -half and half
  std::array<double, 2> radii = {0.0, 0.0};  ///< m

  static Smooth ellipsoid(const Matrix3& axes, const Vector3& lengths) {
    return {.half_axes = axes * lengths.asDiagonal()};
  }
  static Smooth balls(const Vector3& half, const std::array<double, 2>& radii) {
    return {.half = half, .radii = radii};
  }
};

/// How far the solid reaches along a unit direction, m.
inline double reach(const Smooth& solid, const Vector3& direction) {
  const double along = solid.half.dot(direction);
  const double balls =
      solid.radii[0] - along > solid.radii[1] + along ? solid.radii[0] - along : solid.radii[1] + along;
  return (solid.half_axes.transpose() * direction).norm() + balls;
}

}  // namespace atl::audit
