#pragma once

#include <solver/solve_input.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// Keeps contacts of bodies that turn by more than tuning::blind_turn in a step from making energy. Contacts see a
/// body's inertia and its points where they are as a step begins, and a rod that turns on from there would take from
/// their impulses what they had for another direction. An island with such a body ends its step with no more energy
/// than it began with, or these move slower by as much.
///
/// Islands in which nothing else gives energy: no spring, motor, torque or belt, and no body that is led.
class SpinEnergy {
 public:
  /// Before a group's step.
  void begin(const SolveInput& input, const IslandGroup& group);
  /// After it, once bodies have their new poses and velocities.
  void bound(const SolveInput& input) const;

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(islands_, blind_); }

 private:
  struct Watched {
    std::size_t island;
    double energy;           // J, as the step began
    std::size_t first, end;  // of its blind bodies
  };

  std::vector<Watched> islands_;
  std::vector<std::uint32_t> blind_;
};

}  // namespace atl::solver
