#pragma once

#include <solver/direct/direct_island_input.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>

#include <span>
#include <vector>

namespace atl::solver {

/// The angular momentum of an island that nothing holds, which its joints can't change. Their impulses are found with
/// what tension adds to inertia, and turn bodies that don't have it: what that makes is taken back at the step's end,
/// by a turn of the whole, along which joints have no rate.
class FloatingMomentum {
 public:
  FloatingMomentum() = default;
  /// At these velocities. An island floats if all that its joints join are bodies of it, and none is a gear, whose
  /// bearings are elsewhere.
  FloatingMomentum(const Joint* joints, const IslandProblem& problem, std::span<const MovingBody> bodies);

  /// Notes what forces from outside do: the problem's free velocities over its velocities.
  void add_forces(const IslandProblem& problem, std::span<const MovingBody> bodies);
  /// Turns the whole as much faster as is lacking.
  void restore(std::span<const MovingBody> bodies, IslandProblem& problem) const;

 private:
  bool floats_ = false;
  Vector3 about_ = Vector3::Zero();     // m, what it is about
  Vector3 momentum_ = Vector3::Zero();  // kg m^2/s, that there should be
};

}  // namespace atl::solver
