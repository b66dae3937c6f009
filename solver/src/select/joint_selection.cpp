#include <solver/select/joint_selection.h>
#include <solver/tuning.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace atl::solver {
namespace {

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
    if (std::max(a, b) > tuning::light_ratio * std::min(a, b)) return true;
  }
  if (links.size() <= tuning::long_chain) return false;
  const Neighbours neighbours(links, bodies);
  return neighbours.farthest(neighbours.farthest(0).first).second > tuning::long_chain;
}

}  // namespace

bool joins_directly(std::span<const JointLink> links, const BodyTable& bodies, JointMethod method) {
  return method == JointMethod::Direct || (method == JointMethod::Auto && asks_for_direct(links, bodies));
}

}  // namespace atl::solver
