#pragma once

#include <solver/solve_input.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// Keeps what only holds from making energy, over a step. An island in which nothing gives any (no torque, belt or
/// motor with a speed, and no body that is led) ends its step with no more than it began with, what springs, servos and
/// rotors store included, or bodies move slower by as much:
///
/// - those that may turn by more than tuning::blind_turn in the step. Contacts know a body's inertia and points where
///   they are as a step begins: a rod that turns on from there would take from their impulses what they had for another
///   direction.
/// - those that overlap another body by more than tuning::deep_overlap of the smaller one's inner radius, as only what
/// is
///   put into one place does. Each of many overlaps in a row pushes apart at its own speed, which the sweeps that take
///   that back don't get to the end of.
/// - all in islands with joints that touch something. What an impact took to stop a heavy link is carried over into the
///   next substep, in which nothing is to be stopped, and the few sweeps of that don't take all of it back.
class PassiveEnergy {
 public:
  /// Records the energies before a group's step.
  void begin(const SolveInput& input, const IslandGroup& group);
  /// Bounds them after it, once bodies have their new poses and velocities.
  void bound(const SolveInput& input) const;

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(islands_, watched_); }

 private:
  void watch_overlapping(const SolveInput& input, std::size_t island, std::size_t first);

  struct Island {
    std::size_t island;
    double most;             // J, as its step may end
    double moving, springs;  // J, of motion and in springs and servos, as it began
    std::size_t first, end;  // of its bodies that are watched
  };

  std::vector<Island> islands_;
  std::vector<std::uint32_t> watched_;  // bodies
};

}  // namespace atl::solver
