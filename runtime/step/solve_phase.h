#pragma once

#include <jobs/compact_array.h>
#include <jobs/scratch.h>
#include <solver/direct/direct_island.h>
#include <solver/islands/islands.h>
#include <solver/select/solver_selection.h>
#include <solver/select/substep_control.h>
#include <solver/sweep/group_solver.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "step/island_phase.h"
#include "step/step_context.h"
#include "world/stores.h"

namespace atl {

/// Islands -> velocities and poses: chooses how each island is solved, packs islands into groups, and solves the groups
/// as tasks.
class SolvePhase {
 public:
  /// How many substeps islands get whose errors have a target; islands whose contacts carry too much are solved on
  /// their own, and otherwise.
  void choose_modes(Stores& world, const StepContext& step, IslandPhase& islands);
  /// Contacts have friction or restitution that had none, or the reverse: large groups are coloured anew.
  void recolour() { regrouped_ = true; }
  /// `added_slips` as in SolveInput. Adds the bodies that moved far, or whose joints did, to `moved`.
  void solve(Stores& world, const StepContext& step, const solver::AddedSlip* added_slips, IslandPhase& islands,
             solver::FastBodies& moved);
  /// Errors of the step that count for the next one, and which islands have some beyond its target.
  void record_errors(Stores& world, const StepContext& step, std::span<const solver::TouchingPair> touching,
                     const IslandPhase& islands);

  std::span<const solver::IslandGroup> groups() const { return groups_; }
  std::span<const solver::GroupReport> group_reports() const { return group_reports_; }
  /// The contact problem of the last step, if it was to be kept.
  const solver::ContactCapture& capture() const { return capture_; }
  /// By contact slot, N s: see SolveInput::pushed; empty where nobody asks for events.
  std::span<const float> pushed() const { return pushed_; }

  // See jobs/arrays.h.
  auto group_arrays() const { return std::tie(groups_, group_reports_, large_solvers_); }
  auto direct_arrays() const { return std::tie(direct_.solvers, direct_.of_group, direct_.reports); }
  std::size_t direct_count() const { return direct_.solvers.size(); }
  auto selection_arrays() const { return std::tie(modes_, substeps_, group_keys_, settings_, failed_); }
  auto event_arrays() const { return std::tie(pushed_); }
  auto capture_arrays() const { return std::tie(capture_.answers, capture_.motions); }

 private:
  // Groups that are solved at once, each by a solver of its own that keeps its order of elimination.
  struct DirectGroups {
    jobs::CompactArray<std::unique_ptr<solver::DirectIsland>> solvers;
    jobs::CompactArray<solver::DirectIsland*> of_group;  // or empty
    jobs::CompactArray<solver::DirectIslandReport> reports;
  };

  // How the groups of some islands are solved.
  struct GroupSettings {
    solver::SolveMode mode;
    int substeps;  // before the mode makes more of them
    solver::SolverSettings settings;
  };

  bool choose_substeps(Stores& world, const StepContext& step, const IslandPhase& islands);
  void choose_group_keys(const Stores& world, const solver::Islands& islands);
  void choose_settings(const Stores& world, int asked);
  const GroupSettings* find_settings(const solver::IslandGroup& group, int asked) const;
  void solve_groups(Stores& world, const StepContext& step, const solver::AddedSlip* added_slips, IslandPhase& islands,
                    solver::FastBodies& moved);
  solver::SolveMode mode_of(const solver::IslandGroup& group) const;
  int substeps_of(const solver::IslandGroup& group, int asked) const;
  void prepare_direct_solvers(const solver::Islands& islands);
  bool solve_directly(const solver::SolveInput& input, std::size_t group, bool profile);
  void record_modes(Stores& world, const solver::Islands& islands, StepCounts& counts);

  std::vector<solver::IslandGroup> groups_;
  jobs::CompactArray<solver::GroupReport> group_reports_;
  jobs::CompactArray<std::unique_ptr<solver::GroupSolver>> large_solvers_;  // of large groups, in order
  jobs::CompactArray<solver::SolveMode> modes_;                             // by island, or empty
  jobs::CompactArray<std::uint16_t> substeps_;                              // likewise
  jobs::CompactArray<std::uint32_t> group_keys_;                            // by island: see pack_groups()
  jobs::CompactArray<GroupSettings> settings_;                              // one for each that some group has
  bool regrouped_ = false;                                                  // since the last solve
  DirectGroups direct_;
  jobs::CompactArray<std::uint32_t> failed_;  // bodies of islands that could not be solved at once
  solver::ContactCapture capture_;
  jobs::CompactArray<float> pushed_;
};

}  // namespace atl
