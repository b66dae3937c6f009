#pragma once

#include <solver/direct/solve_input.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace atl::solver {

/// Keeps what only holds from making energy, over a step. An island in which nothing gives any but motors (no torque or
/// belt, and no body that is led) ends its step with no more than it began with and motors can have given, what
/// springs, servos and rotors store included, or bodies move slower by as much:
///
/// - those that may turn by more than tuning::blind_turn in the step. Contacts know a body's inertia and points where
///   they are as a step begins: a rod that turns on from there would take from their impulses what they had for another
///   direction.
/// - all in an island in which none of these are, and two overlap by more than tuning::deep_overlap of the smaller
///   one's inner radius. Each of many overlaps in a row pushes apart at its own speed, which the sweeps that take that
///   back don't get to the end of. Baumgarte's pushes are left as they are.
/// - all in islands with joints that touch something. What an impact took to stop a heavy link is carried over into the
///   next substep, in which nothing is to be stopped, and the few sweeps of that don't take all of it back.
/// - all in islands of swept joints that only hold. Bodies turn after joints have seen their inertia, and gaps close at
///   speeds that lift what they move.
///
/// Contacts lift for nothing what they push out of an overlap: where one is stiffer than before, as in a shorter
/// substep, or began too deep. That work is given: the force of each contact by how far it parts, and no more than what
/// rises in the step gains in height. What is struck is lifted by its own motion, and counts as nothing.
class PassiveEnergy {
 public:
  /// Records the energies before a group's step. `deepest` (m): no contact's separation is below, if that is known.
  void begin(const SolveInput& input, const IslandGroup& group,
             float deepest = -std::numeric_limits<float>::infinity());
  /// Bounds them after it, once bodies have their new poses and velocities.
  void bound(const SolveInput& input) const;

  /// A body as the step begins.
  struct BodyStart {
    BodyPose pose;
    Vector3 velocity;  ///< m/s
    Vector3 spin;      ///< rad/s
  };

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(islands_, watched_, starts_); }

 private:
  struct Island {
    std::size_t island;
    bool stores;             // some joint has energy of its own
    double max;              // J, as its step may end
    double moving, springs;  // J, of motion and in springs and servos, as it began
    std::size_t first, end;  // of its bodies that are watched
    std::size_t starts;      // where those of its bodies begin, if something touches
  };

  std::vector<Island> islands_;
  std::vector<std::uint32_t> watched_;  // bodies
  std::vector<BodyStart> starts_;       // of all bodies of islands that touch something, as the step begins
};

}  // namespace atl::solver
