#pragma once

#include <solver/direct/solve_input.h>
#include <solver/sweep/group_parts.h>
#include <solver/sweep/group_report.h>

namespace atl::jobs {
class WorkerTeam;
}

namespace atl::solver {

/// Says if a group has the colours of contacts that the same solver gave it the last time.
enum class GroupColours { New, Kept };

/// Solves island groups: soft substeps with relaxation ("TGS soft": Catto, "Solver2D", 2024) over coloured
/// blocks of joints and of contacts. Its memory is reused from group to group and stays in cache; only the colours of
/// contacts that are kept outlive a solve.
class GroupSolver {
 public:
  /// Solves a group on the calling thread alone.
  GroupReport solve(const SolveInput& input, const IslandGroup& group);
  /// Every loop shared with a team; the same bits. A group whose contacts, their order and bodies are those of the last
  /// call is not coloured again.
  GroupReport solve(const SolveInput& input, const IslandGroup& group, jobs::WorkerTeam& team, GroupColours colours);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(parts_); }

 private:
  template <typename Executor>
  GroupReport run(const SolveInput& input, const IslandGroup& group, Executor& executor, GroupColours colours);
  void collect(const SolveInput& input, const IslandGroup& group);
  void collect_joints(const SolveInput& input, const IslandGroup& group);
  void select_kernels(const SolveInput& input, const IslandGroup& group, GroupReport& report);
  template <typename Executor>
  void gather_bodies(const SolveInput& input, const IslandGroup& group, const GroupReport& report, Executor& executor);

  GroupParts parts_;
};

}  // namespace atl::solver
