#pragma once

#include <collision/continuous/sweep.h>

#include "narrowphase/convex_core.h"
#include "narrowphase/gjk.h"

namespace atl::collision {

/// A convex core and how it moves.
struct MovingCore {
  ConvexCore core;
  Motion motion;
  double axis_radius = 0;  ///< m: no point, with the core's radius, is farther from the axis of rotation

  MovingCore(const ConvexCore& convex, const Motion& how);

  /// An upper bound (m in the whole time) of the way of its points along a unit direction that doesn't turn.
  double advance_along(const Vector3& direction) const {
    return motion.translation.dot(direction) + motion.rotation.cross(direction).norm() * axis_radius;
  }
  bool turns() const { return motion.rotation.squaredNorm() > 0; }
  /// The reach (m) along a unit direction at a pose, world.
  double reach(const Pose& pose, const Vector3& direction) const;
};

/// True if a plane across a direction (from the first to the second, world) keeps the two farther apart than the goal
/// up to t_limit. It costs two support points, and settles most sweeps, since most pairs only pass by each other.
bool stay_parted(const MovingCore& first, const MovingCore& second, const SweepGoal& goal, const Vector3& direction,
                 double t_limit);

/// The time up to which the plane keeps them apart; 0 if it doesn't at the start, infinite if for ever.
double parted_until(const MovingCore& first, const MovingCore& second, const SweepGoal& goal, const Vector3& direction);

/// A direction from the first to the second at the start, world; of any length.
Vector3 first_guess(const MovingCore& first, const MovingCore& second);

/// Conservative advancement of two convex cores; see sweep().
bool advance(const MovingCore& first, const MovingCore& second, const SweepGoal& goal, double t_limit, SweepHit& hit);

}  // namespace atl::collision
