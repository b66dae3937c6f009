#pragma once

#include <jobs/arrays.h>
#include <solver/direct/direct_joints.h>
#include <solver/islands/joint_graph.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace atl::solver {

/// The systems of those components of a joint graph that are solved at once, kept for as long as the graph is.
class JointSystems {
 public:
  /// `wanted(component)` says if it is to be solved at once. Components whose loops cause too much fill-in are not.
  template <typename Wanted>
  void build(const JointGraph& graph, std::span<const Joint> joints, const BodyTable& bodies, const Wanted& wanted) {
    systems_.clear();
    systems_.resize(graph.component_count());
    actuated_.assign(graph.component_count(), 0);
    for (std::uint32_t component = 0; component < systems_.size(); ++component) {
      if (!wanted(component)) continue;
      const std::span<const JointLink> links = graph.links_of(component);
      for (const JointLink& link : links) actuated_[component] |= joints[link.joint].is_actuated();
      auto system = std::make_unique<DirectJoints>();
      if (system->analyse(links, joints, bodies)) systems_[component] = std::move(system);
    }
  }

  bool is_direct(std::uint32_t component) const { return systems_[component] != nullptr; }
  /// Tells a component that is solved at once and has servos or rotors.
  bool is_machine(std::uint32_t component) const { return is_direct(component) && actuated_[component] != 0; }
  /// The system of a component that is solved directly.
  DirectJoints& of(std::uint32_t component) { return *systems_[component]; }

  /// Memory held.
  auto arrays() const { return std::tie(systems_, actuated_); }

 private:
  std::vector<std::unique_ptr<DirectJoints>> systems_;  // by component; null where it is solved joint by joint
  std::vector<std::uint8_t> actuated_;                  // likewise; of those that are solved at once
};

inline bool SolveInput::solves_directly(std::uint32_t component) const {
  return settings.joint_method != JointMethod::Iterative && joint_systems->is_direct(component);
}

}  // namespace atl::solver
