#include <jobs/assert.h>
#include <solver/direct/joint_systems.h>
#include <solver/sweep/joined_motion.h>

namespace atl::solver {

void JoinedMotion::build(const SolveInput& input, const IslandGroup& group) {
  const Islands& islands = input.islands;
  const JointGraph& graph = *input.joint_graph;
  const std::span<const JointLink> joints = islands.joints(group.begin, group.end);
  const std::uint32_t first_rank = islands.first_rank(group.begin);
  component_.assign(islands.bodies(group.begin, group.end).size(), none);
  components_.clear();
  direct_.clear();
  if (number_.size() < graph.component_count()) number_.resize(graph.component_count(), none);
  const auto place = [&](std::uint32_t body) { return islands.rank(body) - first_rank; };
  const auto dynamic = [&](std::uint32_t body) { return input.bodies.mobility[body] == Mobility::Dynamic; };
  for (const JointLink& link : joints) {
    const std::uint32_t of_graph = graph.component_of(link.joint);
    std::uint32_t& number = number_[of_graph];
    if (number == none) {
      number = static_cast<std::uint32_t>(components_.size());
      components_.push_back({.of_graph = of_graph, .direct = input.solves_directly(of_graph)});
      if (components_.back().direct) direct_.push_back(of_graph);
    }
    for (const std::uint32_t body : {link.first, link.second}) {
      if (dynamic(body)) {
        ATL_ASSERT(place(body) < component_.size(), body, place(body), component_.size());
        ATL_ASSERT(component_[place(body)] == none || component_[place(body)] == number, body, number);
        component_[place(body)] = number;
        components_[number].locked |= input.bodies.locks[body] != 0;
      } else {
        components_[number].anchored = true;
        components_[number].led |= input.bodies.mobility[body] == Mobility::Kinematic;
      }
    }
  }
  for (const TouchingPair& pair : islands.contacts(group.begin, group.end)) {
    for (const std::uint32_t body : {pair.first, pair.second}) {
      if (!dynamic(body) || !is_joined(place(body))) continue;
      Component& component = components_[component_[place(body)]];
      component.touched = true;
    }
  }
  for (const JointLink& link : joints) number_[graph.component_of(link.joint)] = none;
}

void JoinedMotion::record_forces(std::span<const std::uint32_t> body_ids, const BodyTable& bodies,
                                 const Vector3& gravity) {
  ATL_ASSERT(body_ids.size() == component_.size(), body_ids.size(), component_.size());
  for (Component& component : components_) {
    component.mass = 0;
    component.acceleration.setZero();
  }
  for (std::size_t i = 0; i < body_ids.size(); ++i) {
    if (!falls(i)) continue;
    const std::uint32_t body = body_ids[i];
    Component& component = components_[component_[i]];
    const double mass = 1 / bodies.inverse_mass[body];
    component.mass += mass;
    component.acceleration += mass * bodies.gravity_scale[body] * gravity + bodies.force(body);
  }
  for (Component& component : components_) {
    if (component.mass > 0) component.acceleration /= component.mass;
  }
}

}  // namespace atl::solver
