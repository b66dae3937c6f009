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
    for_impacts_.clear();
    for_impacts_.resize(graph.component_count());
    asked_.assign(graph.component_count(), 0);
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
  /// The system by which a component answers to impacts and to forces that change; null if loops would cause too much
  /// fill-in. That of joints which are otherwise swept is made when it is first asked for. Different components may be
  /// asked for by different threads.
  DirectJoints* for_impacts(const SolveInput& input, std::uint32_t component) {
    if (is_direct(component)) return systems_[component].get();
    if (asked_[component] == 0) {
      asked_[component] = 1;
      auto system = std::make_unique<DirectJoints>();
      const std::span<const Joint> joints(input.joints, input.joint_graph->joint_count());
      if (system->analyse(input.joint_graph->links_of(component), joints, input.bodies)) {
        for_impacts_[component] = std::move(system);
      }
    }
    return for_impacts_[component].get();
  }

  /// Memory held.
  auto arrays() const { return std::tie(systems_, for_impacts_, asked_, actuated_); }

 private:
  std::vector<std::unique_ptr<DirectJoints>> systems_;      // by component; null where it is solved joint by joint
  std::vector<std::unique_ptr<DirectJoints>> for_impacts_;  // by component, of the others
  std::vector<std::uint8_t> asked_;                         // likewise, if they were asked for
  std::vector<std::uint8_t> actuated_;                      // likewise; of those that are solved at once
};

inline bool SolveInput::solves_directly(std::uint32_t component) const {
  return settings.joint_method != JointMethod::Iterative && joint_systems->is_direct(component);
}

}  // namespace atl::solver
