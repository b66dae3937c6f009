#pragma once

#include <jobs/arrays.h>
#include <solver/direct/solve_input.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/islands/joint_graph.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// The components of an island group's bodies that are connected by joints, and the corrections at the start and end of
/// a step that make their motion second order. Bodies are given by their place in the group.
class JoinedMotion {
 public:
  /// Finds the components of a group with joints.
  void build(const SolveInput& input, const IslandGroup& group);

  /// Graph components of the group that are solved at once.
  std::span<const std::uint32_t> direct() const { return direct_; }
  /// The component of the graph that a component is.
  std::uint32_t graph_component(std::uint32_t component) const { return components_[component].of_graph; }
  bool is_joined(std::size_t body) const { return component_[body] != none; }
  bool is_direct(std::size_t body) const { return is_joined(body) && components_[component_[body]].direct; }
  /// Joined one by one, to nothing that is fixed, and touched by nothing: it falls as a whole.
  bool falls(std::size_t body) const {
    if (!is_joined(body)) return false;
    const Component& component = components_[component_[body]];
    return !component.direct && !component.touched && !component.anchored && !component.locked;
  }
  /// Joined one by one, and touched by nothing.
  bool follows(std::size_t body) const {
    return is_joined(body) && !components_[component_[body]].direct && !components_[component_[body]].touched;
  }
  /// True if only joints and forces act on a component that is swept: nothing touches it or leads it along.
  bool is_closed(std::size_t component) const {
    return !components_[component].direct && !components_[component].touched && !components_[component].led;
  }
  bool has_closed() const {
    for (std::size_t c = 0; c < components_.size(); ++c) {
      if (is_closed(c)) return true;
    }
    return false;
  }
  std::size_t body_count() const { return component_.size(); }
  std::size_t component_count() const { return components_.size(); }
  /// The component of a joined body, by the group's own numbers.
  std::uint32_t component_of(std::size_t body) const { return component_[body]; }
  /// m/s^2, of the centre of mass of all that hang together with it.
  Vector3 acceleration(std::size_t body) const { return components_[component_[body]].acceleration; }

  /// Takes in what accelerates the bodies in this step.
  void record_forces(std::span<const std::uint32_t> body_ids, const BodyTable& bodies, const Vector3& gravity);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(component_, components_, direct_, number_); }

 private:
  static constexpr std::uint32_t none = JointGraph::none;

  struct Component {
    std::uint32_t of_graph = none;
    bool direct = false;
    bool touched = false;
    bool anchored = false;
    bool led = false;     // by something kinematic
    bool locked = false;  // a body, along or about axes
    double mass = 0;      // kg
    Vector3 acceleration = Vector3::Zero();
  };

  std::vector<std::uint32_t> component_;  // by body, in components_
  std::vector<Component> components_;
  std::vector<std::uint32_t> direct_;
  std::vector<std::uint32_t> number_;  // by component of the graph; all none between calls
};

}  // namespace atl::solver
