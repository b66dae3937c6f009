#pragma once

#include <collision/shapes/motion_bounds.h>
#include <jobs/scratch.h>
#include <solver/integrate/body_table.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

struct BodyPose {
  Vector3 position;  ///< m
  Quaternion orientation;
};

/// A body that moved in this step, and where it started.
struct MovedBody {
  std::uint32_t body;
  BodyPose start;
};

struct MovedBodies {
  /// Bodies that may have passed through something, or that came out of the step unsound (see state_bounds.h).
  std::vector<MovedBody> fast;
  std::vector<MovedBody> joined;  ///< all that joints act on: if one of them is put back, so is what it is joined to

  void clear() {
    fast.clear();
    joined.clear();
  }
};

/// Moved bodies, by worker. Order them by body before use.
using FastBodies = jobs::Scratch<MovedBodies>;

/// 2 sin(angle / 2) of the turn between two orientations: how far a point 1 m from the axis gets, in a straight line.
inline double turn_chord(const Quaternion& from, const Quaternion& to) {
  return 2 * (from.conjugate() * to).vec().norm();
}

/// J, of a body's motion, and its spin.
double kinetic_energy(const BodyTable& bodies, std::uint32_t body);

/// J, of some bodies' motion.
double kinetic_energy(const BodyTable& bodies, std::span<const std::uint32_t> of);

enum class Momentum : std::uint8_t { Keep, Take };

/// Slows bodies down by so many J, or as many as they have: by their speeds and spins alike, or, if they are to keep
/// their momentum, by their spins and their speeds against each other. `rotors` in J: what turns with them, and slower.
void slow_down(BodyTable& bodies, std::span<const std::uint32_t> of, Momentum momentum, double energy,
               double rotors = 0);

/// True if a body's gain of velocity in a step of dt seconds is a steady change, as in sliding, rolling or tipping, and
/// not an impact. The limit is 4 times what the forces on it, mostly its weight, give it in a step: contacts return
/// these forces several times if a body is pressed on or friction is high. After a steady change the trapezoidal rule
/// applies: it moves the body by half the gain less than the last velocity does, to second order instead of first.
/// `acceleration` in m/s^2, `radius` in m.
bool changes_steadily(const Vector3& gained, const Vector3& gained_spin, double acceleration, double dt, double radius);

/// Keeps account of a body that has moved from `start` in a step of dt seconds: whether it may have used up its
/// margins by the end of the next one, whether it was fast or is unsound, and where it started if it is joined to
/// others.
void record_motion(BodyTable& bodies, collision::MotionBounds& bounds, std::uint32_t body, const BodyPose& start,
                   double dt, MovedBodies& notes);

/// A turn by the vector `turn` (rad) after an orientation. It is exact: a coordinate that moved by less than its rate
/// says would let a rotor on a spring gain energy.
Quaternion turned(const Vector3& turn, const Quaternion& orientation);

}  // namespace atl::solver
