#pragma once

#include <collision/shapes/function_ref.h>
#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>

#include <cstdint>

namespace atl::collision {

/// The motion of a shape over a time of 1: its centre moves along a line at constant speed, while the shape turns about
/// it at constant angular velocity.
struct Motion {
  Pose start{Vector3::Zero(), Quaternion::Identity()};  ///< of the shape's frame, world
  Vector3 centre = Vector3::Zero();                     ///< m, of the turning, shape's frame; usually that of mass
  Vector3 translation = Vector3::Zero();                ///< m, of the centre, world
  Vector3 rotation = Vector3::Zero();                   ///< axis times angle (rad, any size), world

  static Motion still(const Pose& pose) { return {pose}; }
  static Motion along(const Pose& pose, const Vector3& translation) { return {pose, Vector3::Zero(), translation}; }
  /// The motion from one pose to another, turning the shorter way. Like at(), this takes only sums, products and square
  /// roots: the same bits everywhere.
  static Motion between(const Pose& start, const Pose& end, const Vector3& centre);

  Pose at(double t) const;
};

/// The distance at which a sweep ends, and its tolerance.
struct SweepGoal {
  double separation = 0;    ///< m, >= 0: a pair that comes this near hits
  double tolerance = 1e-6;  ///< m, > 0: a hit's separation lies at most this above the goal, and not below it

  /// m: steps aim at the middle of what is allowed, so that rounding never brings them below the goal.
  double aim() const { return separation + 0.5 * tolerance; }
};

/// The first time at which two shapes come as near each other as the goal, and the place.
struct SweepHit {
  static constexpr std::uint32_t no_triangle = ~0u;

  double t = 0;                          ///< in [0, 1]: nothing is nearer than the goal up to then
  Vector3 normal = Vector3::UnitZ();     ///< unit, from the first shape to the second, world
  Vector3 point = Vector3::Zero();       ///< m, on the second shape, world, at t
  double separation = 0;                 ///< m, at t
  std::uint32_t triangle = no_triangle;  ///< of a surface
  bool started_overlapping = false;      ///< t = 0; point and normal mean little
  bool converged = true;                 ///< false: ran out of iterations; t is safe, but maybe early
};

/// The first time up to t_limit (in [0, 1]) at which a bounded convex solid comes near another shape, of any kind.
/// False if it doesn't. A pair that starts within the goal hits at t = 0, unless it can be told that it only moves
/// apart.
///
/// A surface's triangles stop only what comes from their front: those that the solid's centre starts behind are
/// passed over, and so are those that it starts on and moves away from.
///
/// Conservative advancement (Mirtich, "Impulse-based dynamic simulation", 1996): from one safe time to the next by
/// a bound on the closing speed along the separating direction, here with the radius about the axis of rotation
/// (after Zhang, Lee and Kim, "Interactive continuous collision detection for non-convex polyhedra", 2006). Never
/// steps over a contact, however fast or thin the shapes.
bool sweep(const Shape& solid, const Motion& solid_motion, const Shape& other, const Motion& other_motion,
           const SweepGoal& goal, double t_limit, SweepHit& hit);

/// The same to each triangle of a surface by itself, in no order of time; of other shapes to the one that they are.
/// `visit` returns the limit from then on.
void sweep_each(const Shape& solid, const Motion& solid_motion, const Shape& other, const Motion& other_motion,
                const SweepGoal& goal, double t_limit, FunctionRef<double(const SweepHit&)> visit);

}  // namespace atl::collision
