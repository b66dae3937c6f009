#include <jobs/assert.h>
#include <solver/constraints/tendon.h>
#include <solver/islands/joint_graph.h>

#include <algorithm>
#include <numeric>

namespace atl::solver {
namespace {

// The lowest of each set is its root.
std::uint32_t find(jobs::CompactArray<std::uint32_t>& parent, std::uint32_t body) {
  while (parent[body] != body) {
    ATL_ASSERT(parent[body] < body, body, parent[body]);
    parent[body] = parent[parent[body]];
    body = parent[body];
  }
  return body;
}

}  // namespace

void JointGraph::build(std::span<const Joint> joints, std::span<const std::uint8_t> acts, const BodyTable& bodies) {
  ATL_ASSERT(acts.size() == joints.size(), acts.size(), joints.size());
  links_.clear();
  ties_.clear();
  component_of_.assign(joints.size(), none);
  parent_.resize(bodies.size());
  std::iota(parent_.begin(), parent_.end(), 0u);
  const auto dynamic = [&](std::uint32_t body) { return bodies.mobility[body] == Mobility::Dynamic; };
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    const std::uint32_t first = joints[joint].first, second = joints[joint].second;
    if (!acts[joint]) continue;
    if (joints[joint].is_tendon()) {
      add_tendon(joints, joint, bodies);
    } else if (dynamic(first) || dynamic(second)) {
      ATL_ASSERT(first != second && first < bodies.size() && second < bodies.size(), joint, first, second,
                 bodies.size());
      links_.push_back({first, second, joint});
    }
  }
  const auto join_all = [&](const jobs::CompactArray<JointLink>& all) {
    for (const JointLink& link : all) {
      if (!dynamic(link.first) || !dynamic(link.second)) continue;
      const std::uint32_t a = find(parent_, link.first), b = find(parent_, link.second);
      parent_[std::max(a, b)] = std::min(a, b);
    }
  };
  join_all(links_);
  join_all(ties_);

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
  ATL_ASSERT(start_.back() == links_.size(), start_.back(), links_.size());
  sorted_.resize(links_.size());
  std::vector<std::uint32_t> cursor(start_.begin(), start_.end());
  for (const JointLink& link : links_) sorted_[cursor[component_of_[link.joint]]++] = link;
  count_parallel(joints, bodies);
  count_around(bodies);
}

// Adds a tendon. Its link joins two dynamic bodies if it has as many.
void JointGraph::add_tendon(std::span<const Joint> joints, std::uint32_t tendon, const BodyTable& bodies) {
  std::vector<std::uint32_t> pulled;
  std::uint32_t other = none;
  for_each_term(joints.data(), tendon, [&](const Joint& of) {
    for (const std::uint32_t body : {of.first, of.second}) {
      if (bodies.mobility[body] == Mobility::Dynamic) {
        pulled.push_back(body);
      } else {
        other = body;
      }
    }
  });
  std::sort(pulled.begin(), pulled.end());
  pulled.erase(std::unique(pulled.begin(), pulled.end()), pulled.end());
  if (pulled.empty()) return;
  links_.push_back({pulled[0], pulled.size() > 1 ? pulled[1] : other, tendon});
  for (std::size_t i = 2; i < pulled.size(); ++i) ties_.push_back({pulled[0], pulled[i], tendon});
}

// Tendons hold no bodies together, and share nothing.
void JointGraph::count_parallel(std::span<const Joint> joints, const BodyTable& bodies) {
  const auto body_of = [&](std::uint32_t body) {
    return bodies.mobility[body] == Mobility::Dynamic ? body : Islands::none;
  };
  const auto pair_of = [&](const JointLink& link) { return std::minmax({body_of(link.first), body_of(link.second)}); };
  jobs::CompactArray<JointLink> by_pair = links_;
  jobs::erase_if(by_pair, [&](const JointLink& link) { return joints[link.joint].is_tendon(); });
  std::sort(by_pair.begin(), by_pair.end(),
            [&](const JointLink& a, const JointLink& b) { return pair_of(a) < pair_of(b); });
  parallel_.assign(component_of_.size(), 0);
  for (auto begin = by_pair.begin(); begin != by_pair.end();) {
    const auto end =
        std::find_if(begin, by_pair.end(), [&](const JointLink& link) { return pair_of(link) != pair_of(*begin); });
    for (auto link = begin; link != end; ++link) parallel_[link->joint] = static_cast<int>(end - begin);
    begin = end;
  }
}

void JointGraph::count_around(const BodyTable& bodies) {
  jobs::CompactArray<std::uint32_t>& at_body = parent_;
  std::fill(at_body.begin(), at_body.end(), 0);
  for (const JointLink& link : links_) {
    for (const std::uint32_t body : {link.first, link.second}) {
      if (bodies.mobility[body] == Mobility::Dynamic) ++at_body[body];
    }
  }
  for (const JointLink& tie : ties_) ++at_body[tie.second];
  around_.assign(component_of_.size(), 0);
  for (const JointLink& link : links_) {
    for (const std::uint32_t body : {link.first, link.second}) {
      if (bodies.mobility[body] != Mobility::Dynamic) continue;
      around_[link.joint] = std::max(around_[link.joint], static_cast<int>(at_body[body]));
    }
  }
}

std::span<const JointLink> JointGraph::links_of(std::uint32_t component) const {
  ATL_ASSERT(component < component_count(), component, component_count());
  return std::span(sorted_).subspan(start_[component], start_[component + 1] - start_[component]);
}

}  // namespace atl::solver
