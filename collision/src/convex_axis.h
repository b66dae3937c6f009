#pragma once

#include <collision/descent.h>
#include <collision/pose.h>
#include <collision/shape.h>

namespace atl::collision {

/// Two solids in the frame of the first.
struct SolidPair {
  const Shape& first;
  const Shape& second;
  Vector3 position;  ///< m, of the second
  Matrix3 rotation;  ///< its axes, as columns

  double size() const { return first.inner_radius < second.inner_radius ? first.inner_radius : second.inner_radius; }
  /// How far the solids are apart along a unit direction from the first to the second.
  double separation_along(const Vector3& normal) const;
  /// Whether one is a cylinder or a cone.
  bool has_round() const;
};

/// The direction that parts two solids best; where they overlap deeply perhaps but a good one. Builds the cores
/// (polytope.h), which the features found are those of. The separation is exact along the normal; the normal is
/// so too, but for cylinders and cones, which see refine_axis(). False where the solids are farther apart than
/// `margin` (m).
bool find_axis(const SolidPair& pair, double margin, Core& first, Core& second, LocalAxis& axis);

/// Turns the axis found to the best for cylinders and cones themselves, within 0.05 degrees. Nothing to do for
/// other shapes.
void refine_axis(const SolidPair& pair, Core& first, Core& second, LocalAxis& axis);

}  // namespace atl::collision
