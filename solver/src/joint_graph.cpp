#include <solver/joint_graph.h>

#include <algorithm>
#include <numeric>

namespace atl::solver {
namespace {

// The lowest of each set is its root.
std::uint32_t find(std::vector<std::uint32_t>& parent, std::uint32_t body) {
  while (parent[body] != body) {
    parent[body] = parent[parent[body]];
    body = parent[body];
  }
  return body;
}

// The most that one of two joined bodies may weigh of the other, and the longest way through joints, that joints solved
// one by one hold well.
constexpr double light_ratio = 10;
constexpr std::size_t long_chain = 12;

// Bodies joined to each body, of a component.
class Neighbours {
 public:
  explicit Neighbours(std::span<const JointLink> links, const BodyTable& bodies) {
    for (const JointLink& link : links) {
      for (const std::uint32_t body : {link.first, link.second}) {
        if (bodies.mobility[body] == Mobility::Dynamic) bodies_.push_back(body);
      }
    }
    std::sort(bodies_.begin(), bodies_.end());
    bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
    of_.resize(bodies_.size());
    for (const JointLink& link : links) {
      if (bodies.mobility[link.first] != Mobility::Dynamic || bodies.mobility[link.second] != Mobility::Dynamic)
        continue;
      const std::size_t a = place(link.first), b = place(link.second);
      of_[a].push_back(b);
      of_[b].push_back(a);
    }
  }

  // The body that is farthest from a given one, and by how many joints.
  std::pair<std::size_t, std::size_t> farthest(std::size_t from) const {
    std::vector<std::size_t> distance(of_.size(), ~std::size_t{0});
    std::vector<std::size_t> reached = {from};
    distance[from] = 0;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const std::size_t other : of_[reached[i]]) {
        if (distance[other] != ~std::size_t{0}) continue;
        distance[other] = distance[reached[i]] + 1;
        reached.push_back(other);
      }
    }
    return {reached.back(), distance[reached.back()]};
  }

 private:
  std::size_t place(std::uint32_t body) const {
    return static_cast<std::size_t>(std::lower_bound(bodies_.begin(), bodies_.end(), body) - bodies_.begin());
  }

  std::vector<std::uint32_t> bodies_;
  std::vector<std::vector<std::size_t>> of_;
};

// Whether solving joint by joint would not do: what hangs on something swings for long, and machines stand on
// something; there errors add up.
bool asks_for_direct(std::span<const JointLink> links, const BodyTable& bodies) {
  for (const JointLink& link : links) {
    const double a = bodies.inverse_mass[link.first], b = bodies.inverse_mass[link.second];
    if (a == 0 || b == 0) return true;
    if (std::max(a, b) > light_ratio * std::min(a, b)) return true;
  }
  if (links.size() <= long_chain) return false;
  const Neighbours neighbours(links, bodies);
  return neighbours.farthest(neighbours.farthest(0).first).second > long_chain;
}

}  // namespace

void JointGraph::build(std::span<const Joint> joints, std::span<const std::uint8_t> acts, const BodyTable& bodies,
                       JointMethod method) {
  links_.clear();
  component_of_.assign(joints.size(), none);
  parent_.resize(bodies.size());
  std::iota(parent_.begin(), parent_.end(), 0u);
  const auto dynamic = [&](std::uint32_t body) { return bodies.mobility[body] == Mobility::Dynamic; };
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    const std::uint32_t first = joints[joint].first, second = joints[joint].second;
    if (!acts[joint] || !(dynamic(first) || dynamic(second))) continue;
    links_.push_back({first, second, joint});
    if (!dynamic(first) || !dynamic(second)) continue;
    const std::uint32_t a = find(parent_, first), b = find(parent_, second);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  // Numbers components as their first joint comes up, and sorts joints by component.
  component_of_root_.assign(bodies.size(), none);
  start_.assign(1, 0);
  for (const JointLink& link : links_) {
    const std::uint32_t root = find(parent_, dynamic(link.first) ? link.first : link.second);
    if (component_of_root_[root] == none) {
      component_of_root_[root] = static_cast<std::uint32_t>(start_.size()) - 1;
      start_.push_back(0);
    }
    component_of_[link.joint] = component_of_root_[root];
    ++start_[component_of_[link.joint] + 1];
  }
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  sorted_.resize(links_.size());
  std::vector<std::uint32_t> cursor(start_.begin(), start_.end());
  for (const JointLink& link : links_) sorted_[cursor[component_of_[link.joint]]++] = link;

  systems_.resize(component_count());
  direct_joints_ = 0;
  for (std::uint32_t component = 0; component < component_count(); ++component) {
    const std::span<const JointLink> own = links_of(component);
    systems_[component].reset();
    if (method == JointMethod::Iterative) continue;
    if (method == JointMethod::Auto && !asks_for_direct(own, bodies)) continue;
    auto system = std::make_unique<DirectJoints>();
    if (!system->analyse(own, joints, bodies)) continue;
    systems_[component] = std::move(system);
    direct_joints_ += own.size();
  }
}

std::span<const JointLink> JointGraph::links_of(std::uint32_t component) const {
  return std::span(sorted_).subspan(start_[component], start_[component + 1] - start_[component]);
}

std::size_t JointGraph::bytes() const {
  std::size_t all = jobs::bytes_of(links_, component_of_, sorted_, start_, systems_, parent_, component_of_root_);
  for (const std::unique_ptr<DirectJoints>& system : systems_) {
    if (system != nullptr) all += sizeof(DirectJoints) + system->bytes();
  }
  return all;
}

}  // namespace atl::solver
