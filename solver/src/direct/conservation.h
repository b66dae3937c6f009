#pragma once

#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <span>
#include <vector>

namespace atl::solver {

/// J, of an island's bodies alone, at these velocities.
double kinetic_energy(std::span<const MovingBody> bodies, const IslandProblem& problem,
                      const std::vector<double>& velocity);

/// The energy and the angular momentum of an island that nothing touches, over a step: joints can't change the first
/// where they only hold, and turn rotors, without ranges; nor the second where nothing holds the island. A leapfrog of
/// springs needs no more: it is off by as much at the end as at the start, and its frequencies would be farther off.
/// Both are restored as the step ends, along motions that joints allow (Hairer, Lubich and Wanner, "Geometric Numerical
/// Integration", IV.4: projection onto invariants): momentum by a turn of the whole, energy by a factor on the speeds
/// of bodies against each other, or against what holds them.
class Conservation {
 public:
  Conservation() = default;
  /// Notes both when the step begins, with rows in place.
  Conservation(const SolveInput& input, const RowKinds& rows, const IslandProblem& problem,
               std::span<const MovingBody> bodies);

  /// Notes what forces from outside do: the problem's free velocities over its velocities.
  void add_forces(const IslandProblem& problem, std::span<const MovingBody> bodies);
  /// Restores them when the step ends. `resolved`: joints are closed, and arms have turned by little in each substep;
  /// else energy is left as it is.
  void restore(const SolveInput& input, std::span<const MovingBody> bodies, bool resolved,
               IslandProblem& problem) const;

 private:
  bool all_locked_ = true;              // rows of joints
  bool floats_ = false;                 // nothing holds the island
  bool keeps_energy_ = false;           // joints only hold, and turn rotors
  Vector3 about_ = Vector3::Zero();     // m, what momentum is about
  Vector3 momentum_ = Vector3::Zero();  // kg m^2/s, that there should be
  double energy_ = 0;                   // J, of motion, as the step begins
};

}  // namespace atl::solver
