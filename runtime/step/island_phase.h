#pragma once

#include <jobs/compact_array.h>
#include <solver/direct/joint_systems.h>
#include <solver/islands/islands.h>
#include <solver/islands/joint_graph.h>

#include <cstdint>
#include <span>
#include <utility>

#include "step/contact_phase.h"
#include "step/step_context.h"
#include "world/stores.h"

namespace atl {

/// Touching contacts and joints -> islands; what is touched or pulled wakes. Islands depend on who is awake, what
/// touches and what is joined, so while these stay what they were, the islands do.
class IslandPhase {
 public:
  void build(Stores& world, const StepContext& step, ContactPhase& contacts);

  const solver::Islands& islands() const { return islands_; }
  bool rebuilt() const { return rebuilt_; }    ///< by the last step
  bool one_each() const { return one_each_; }  ///< a group for each island, that stops sweeping when it is done
  const solver::JointGraph& joint_graph() const { return joint_graph_; }
  solver::JointSystems& joint_systems() { return joint_systems_; }
  const solver::JointSystems& joint_systems() const { return joint_systems_; }
  /// By number, what joints connect a body to that some act on.
  std::uint32_t assembly_of(std::uint32_t joined_body) const { return assembly_[joined_body]; }
  std::span<const std::uint32_t> assemblies() const { return assembly_; }
  /// Joints of awake bodies.
  std::span<const solver::JointLink> acting_joints() const { return islands_.joints(0, islands_.count()); }

  auto arrays() const { return std::tie(islands_); }
  auto joint_arrays() const {
    return std::tie(longest_substeps_, to_kinematic_, assembly_, joint_graph_, joint_systems_);
  }

 private:
  void update_joint_graph(Stores& world, double h);
  void wake_joined_to_moving(Stores& world) const;
  void count_joints(StepCounts& counts);

  solver::Islands islands_;
  bool rebuilt_ = false;
  bool one_each_ = false;
  solver::JointGraph joint_graph_;
  double joint_substep_ = 0;                     // s, for which joints were shared out between the solvers
  jobs::CompactArray<double> longest_substeps_;  // s, by component: see longest_substep()
  solver::JointSystems joint_systems_;           // by component of the graph
  jobs::CompactArray<std::uint32_t> assembly_;   // by joined body: its component of the graph
  jobs::CompactArray<std::pair<std::uint32_t, std::uint32_t>>
      to_kinematic_;                // kinematic bodies, and what is joined to them
  std::int64_t direct_joints_ = 0;  // of awake bodies
};

}  // namespace atl
