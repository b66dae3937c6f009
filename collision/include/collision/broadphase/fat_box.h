#pragma once

#include <collision/shapes/aabb.h>

namespace atl::collision {

/// Number of steps ahead for which a fat box contains a shape that keeps its velocity. Tuned with
/// perf/broadphase_benchmark on 10,000 unit boxes that move by 5% of their size a step: from 0 to 4 steps the
/// broadphase's mean time falls by 30-50%, to 8 by 15% more, but each step adds 6% to the pairs, and every pair costs a
/// contact's update.
constexpr double predicted_steps = 4;

/// The box to give a shape in the broadphase: its bounds, grown by `aabb_margin` >= 0 (m) on all sides, and by a swept
/// margin along where it will be if it keeps moving by `displacement_per_step` (m), so that it doesn't leave its box
/// again at once.
///
/// The first margin alone must do for motion that turns in every step: there 15% of the shape's size on each side took
/// half the moves of 10% and 3/4 of the time, with 1/4 more pairs; for straight motion 5% will do. The swept margin is
/// at most as long as the bounds' longest edge: what is faster meets new shapes in every step anyway, and a longer box
/// would have pairs with all that it passes by.
inline Aabb fattened(const Bounds& bounds, double aabb_margin, const Vector3& displacement_per_step) {
  const double longest = (bounds.upper - bounds.lower).maxCoeff();
  const double way = predicted_steps * displacement_per_step.norm();
  const double steps = way > longest ? predicted_steps * (longest / way) : predicted_steps;
  const Vector3 swept = steps * displacement_per_step;
  const Vector3 margin = Vector3::Constant(aabb_margin);
  return Aabb::around(bounds.lower - margin + swept.cwiseMin(0.0), bounds.upper + margin + swept.cwiseMax(0.0));
}

}  // namespace atl::collision
