#pragma once

#include <jobs/arrays.h>
#include <solver/direct/balance_search.h>
#include <solver/direct/island_problem.h>
#include <solver/solver_settings.h>

#include <cstddef>
#include <vector>

namespace atl::solver {

/// An island's velocities, which are solved for twice, as with sweeps of soft contacts: bodies keep velocities at which
/// contacts just stop, and move by velocities at which overlap is parted, too.
struct IslandMotions {
  IslandProblem problem;  ///< its velocity is what bodies move by
  BalanceSearch search;
  std::vector<double> lasting;  ///< m/s, rad/s, six numbers a body: what bodies come with, and then what they keep
  bool pushes = false;          ///< bodies move by other velocities than they keep
  double energy_before = 0;     ///< J, kinetic, before a substep's impulses; where something may bounce

  /// Makes room for as many bodies.
  void resize(std::size_t body_count) {
    problem.resize(body_count);
    search.resize(body_count);
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(problem, search, lasting); }
};

/// Finds both, over `dt` seconds. `from_outside` as is_bounded() has it. Returns false where that ends nowhere.
bool find_motions(IslandMotions& motions, const SolverSettings& settings, double dt, double from_outside);

/// Makes contacts such that they stop what closes them in dt seconds, and no more.
void stop_contacts(std::vector<DirectContact>& contacts, double dt);

}  // namespace atl::solver
