#pragma once

#include <jobs/arrays.h>
#include <solver/direct/island_members.h>
#include <solver/direct/island_motions.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <cstdint>
#include <vector>

namespace atl::solver {

/// The outcome of a direct solve.
struct DirectIslandReport {
  bool solved = false;       ///< if not, no state was changed
  const char* why_not = "";  ///< static storage
  int iterations = 0;        ///< of Newton's method, beyond the first solves
  // Contacts, and those of them that have more than one point, two bodies that can move, or friction.
  std::int64_t contacts = 0, several_points = 0, two_movable = 0, friction = 0;
  std::int64_t gyroscopic_bodies = 0;  ///< whose moments of inertia differ
  double ms = 0;                       ///< with SolverSettings::profile
};

/// An island whose contacts and joints are solved at once, as one system (IslandProblem): one so ill-conditioned (tall
/// columns, heavy bodies on light ones, loaded bridges) that sweeps get nowhere.
///
/// Contacts alone take one solve for a whole step. With joints there is one for each substep, which is one of RATTLE
/// (see DirectJoints) with the contacts in it. Each finds two sets of velocities (IslandMotions).
///
/// The first solve takes each contact to be on the pieces that the impulses of the last step tell of, and at rest is
/// all there is to do. No state outlives a step, but the order of elimination, which the pairs determine.
class DirectIsland {
 public:
  /// Takes in an island. Returns false if its factor would be too large.
  bool analyse(const SolveInput& input, const IslandGroup& group);
  static constexpr const char* too_large = "its factor would be too large";
  /// Solves the island that was taken in last. Not solved is what bounces, tumbles fast or didn't converge.
  DirectIslandReport solve(const SolveInput& input);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(members_, motions_, bodies_); }

 private:
  IslandMembers members_;
  bool fits_ = false;
  IslandMotions motions_;
  std::vector<MovingBody> bodies_;
};

}  // namespace atl::solver
