#include <jobs/assert.h>
#include <jobs/prefetch.h>
#include <solver/select/load_estimate.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

using Vector3f = Eigen::Vector3f;

Vector3f row(const float (&from)[3]) { return Vector3f(from[0], from[1], from[2]); }

constexpr float infinite = std::numeric_limits<float>::infinity();

// m^2, along the normal, from a dynamic body's centre of mass to the contact.
float thickness_square(const Vector3f& normal, const Vector3f& arm) {
  constexpr auto min = static_cast<float>(tuning::min_thickness * tuning::min_thickness);
  const float along = normal.dot(arm);
  return std::max(along * along, min * arm.squaredNorm());
}

}  // namespace

LoadEstimate::Overload LoadEstimate::of(const LoadInput& input, std::size_t island, Build build) {
  Overload found;
  const double g = input.gravity.norm();
  if (!(g > 0)) return found;
  const Vector3 up = -input.gravity / g;
  const Vector3f up_f = up.cast<float>();
  const auto softness = static_cast<float>(SubstepConstants::penetration_by_load(input.settings, input.dt));
  const auto allowed =
      static_cast<float>(build == Build::Columns ? tuning::column_penetration : tuning::overload_penetration);
  const std::span<const std::uint32_t> bodies = input.islands.bodies(island, island + 1);
  const std::uint32_t first_rank = input.islands.first_rank(island);
  const double ground = up.dot(input.bodies.position(bodies.front()));
  nodes_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::uint32_t body = bodies[i];
    const double inverse_mass = input.bodies.inverse_mass[body];
    ATL_ASSERT(inverse_mass > 0, body, inverse_mass);
    nodes_[i] = {.height = static_cast<float>(up.dot(input.bodies.position(body)) - ground),
                 .load = static_cast<float>(g * input.bodies.gravity_scale[body] / inverse_mass),
                 .inverse_mass = static_cast<float>(inverse_mass),
                 .on_top = 0,
                 .supports = 0,
                 .support = Islands::none,
                 .overloaded = false};
  }

  supports_.clear();
  const std::span<const TouchingPair> contacts = input.islands.contacts(island, island + 1);
  constexpr std::size_t ahead = 8;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (i + ahead < contacts.size()) jobs::prefetch_lines(&input.manifolds[contacts[i + ahead].slot], 1);
    const TouchingPair& pair = contacts[i];
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const Vector3f normal = row(manifold.normal);  // it points to the second
    const float slope = up_f.dot(normal);
    if (!(std::abs(slope) >= static_cast<float>(tuning::min_slope))) continue;
    const bool first_moves = input.bodies.mobility[pair.first] == Mobility::Dynamic;
    const bool second_moves = input.bodies.mobility[pair.second] == Mobility::Dynamic;
    const bool second_above = slope > 0;
    if (!(second_above ? second_moves : first_moves)) continue;
    const std::uint32_t first = first_moves ? input.islands.rank(pair.first) - first_rank : Islands::none;
    const std::uint32_t second = second_moves ? input.islands.rank(pair.second) - first_rank : Islands::none;
    ATL_ASSERT(first == Islands::none || first < nodes_.size(), pair.first, first, nodes_.size());
    ATL_ASSERT(second == Islands::none || second < nodes_.size(), pair.second, second, nodes_.size());
    const std::uint32_t above = second_above ? second : first, below = second_above ? first : second;
    float thickness = infinite, give = softness;
    if (first_moves) thickness = thickness_square(normal, row(manifold.anchor_first));
    if (second_moves) thickness = std::min(thickness, thickness_square(normal, row(manifold.anchor_second)));
    if (below == Islands::none) {
      give *= 0.25f * nodes_[above].inverse_mass;
    } else {
      give *= nodes_[above].inverse_mass + nodes_[below].inverse_mass;
      nodes_[below].on_top += nodes_[below].height < nodes_[above].height;
    }
    Node& node = nodes_[above];
    ++node.supports;
    supports_.push_back({.above = above,
                         .below = below,
                         .next = node.support,
                         .capacity = allowed * std::sqrt(thickness) * std::abs(slope) / give,
                         .contact = static_cast<std::uint32_t>(i)});
    node.support = static_cast<std::uint32_t>(supports_.size() - 1);
  }

  free_.clear();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].on_top == 0) free_.push_back(i);
  }
  for (std::size_t i = 0; i < free_.size(); ++i) {
    const Node& node = nodes_[free_[i]];
    const float load = node.load / static_cast<float>(node.supports);
    for (std::uint32_t s = node.support; s != Islands::none; s = supports_[s].next) {
      const Support& support = supports_[s];
      const std::uint32_t below = support.below;
      if (below != Islands::none && nodes_[below].height < node.height) {
        ATL_ASSERT(nodes_[below].on_top > 0, island, below);
        nodes_[below].load += load;
        if (--nodes_[below].on_top == 0) free_.push_back(below);
      }
      if (!(load > support.capacity)) continue;
      Node& lighter = below != Islands::none && nodes_[below].inverse_mass > node.inverse_mass ? nodes_[below]
                                                                                               : nodes_[support.above];
      found.bodies += !lighter.overloaded;
      lighter.overloaded = true;
      found.deep |= is_deep(input, contacts[support.contact], load, build);
    }
  }
  return found;
}

bool LoadEstimate::is_deep(const LoadInput& input, const TouchingPair& pair, double load, Build build) const {
  const double first = input.bodies.inverse_mass[pair.first], second = input.bodies.inverse_mass[pair.second];
  if (build == Build::Joined) {
    const auto [heavy, light] = std::minmax(first, second);
    return heavy > 0 && light >= tuning::deep_ratio * heavy;
  }
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  const double slope = std::abs(input.gravity.normalized().dot(get3(manifold.normal)));
  float arm = infinite;
  if (first > 0) arm = row(manifold.anchor_first).norm();
  if (second > 0) arm = std::min(arm, row(manifold.anchor_second).norm());
  const double softness =
      (first > 0 && second > 0 ? 1 : 0.25) * SubstepConstants::penetration_by_load(input.settings, input.dt);
  return softness * load / slope * (first + second) > tuning::deep_penetration * arm;
}

}  // namespace atl::solver
