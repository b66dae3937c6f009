#pragma once

#include <jobs/arrays.h>
#include <solver/direct/solve_input.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/sweep/joined_motion.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// The inertia that joints which are solved one by one see of a group's bodies: tension counts as inertia, and that of
/// bodies with unequal moments turns with them in the step. Bodies by their place in the group.
class JointInertia {
 public:
  /// Starts a step without any tension, for the rows of SolverBodies from `first_dynamic` on.
  void reset(std::uint32_t first_dynamic, std::size_t body_count) {
    first_dynamic_ = first_dynamic;
    stiffness_.assign(first_dynamic + body_count, Matrix3::Zero());
    followers_.clear();
  }
  /// N m, by index into SolverBodies, for joints to add theirs.
  std::span<Matrix3> stiffness() { return stiffness_; }

  /// Adds tension to the inertia of bodies [begin, end) that it turns back faster than substeps can follow.
  void stiffen(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin, std::size_t end,
               SolverBodies& rows);
  /// Lists the bodies whose inertia is to turn with them in the step, once all are stiffened.
  void find_followers(const SolveInput& input, std::span<const std::uint32_t> bodies, const JoinedMotion& joined);
  /// Turns their inertia after bodies have turned in a substep.
  void follow(const SolveInput& input, std::span<const std::uint32_t> bodies, SolverBodies& rows);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(stiffness_, followers_); }

 private:
  // A body whose inertia joints see turn with it.
  struct Follower {
    std::uint32_t place;
    Matrix3 inertia;  // kg m^2, world frame, as velocities were last changed with it
  };

  std::uint32_t first_dynamic_ = 1;
  std::vector<Matrix3> stiffness_;  // N m
  std::vector<Follower> followers_;
};

}  // namespace atl::solver
