#include <solver/select/load_estimate.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "constraints/loaded_contact.h"
#include "integrate/rows3.h"

namespace atl::solver {
void LoadEstimate::add_overloaded(const LoadInput& input, std::size_t island, std::vector<OverloadedBody>& overloaded) {
  const double g = input.gravity.norm();
  if (!(g > 0)) return;
  const Vector3 up = -input.gravity / g;
  const std::span<const std::uint32_t> bodies = input.islands.bodies(island, island + 1);
  const Build build = build_of(input.islands, island);
  // m by N and 1/kg
  const double by_force =
      SubstepConstants::penetration_by_impulse(input.settings, input.dt) * input.dt / input.settings.substeps;
  const std::uint32_t first_rank = input.islands.first_rank(island);
  const auto place = [&](std::uint32_t body) {
    return input.bodies.mobility[body] == Mobility::Dynamic ? input.islands.rank(body) - first_rank : Islands::none;
  };
  height_.resize(bodies.size());
  load_.resize(bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    height_[i] = up.dot(input.bodies.position(bodies[i]));
    load_[i] = g * input.bodies.gravity_scale[bodies[i]] / input.bodies.inverse_mass[bodies[i]];
  }

  supports_.clear();
  for (const TouchingPair& pair : input.islands.contacts(island, island + 1)) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const Vector3 normal = get3(manifold.normal);
    const double slope = up.dot(normal);  // it points to the second
    const bool second_above = slope > 0;
    const std::uint32_t upper = second_above ? pair.second : pair.first;
    const std::uint32_t lower = second_above ? pair.first : pair.second;
    if (!(std::abs(slope) >= tuning::least_slope) || place(upper) == Islands::none) continue;
    supports_.push_back({.above = place(upper),
                         .below = place(lower),
                         .along = std::abs(slope),
                         .slot = pair.slot,
                         .first = pair.first,
                         .second = pair.second});
  }
  std::stable_sort(supports_.begin(), supports_.end(),
                   [](const Support& a, const Support& b) { return a.above < b.above; });
  start_.assign(bodies.size() + 1, 0);
  for (const Support& support : supports_) ++start_[support.above + 1];
  std::partial_sum(start_.begin(), start_.end(), start_.begin());

  order_.resize(bodies.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return height_[a] > height_[b]; });
  for (const std::uint32_t above : order_) {
    const std::uint32_t count = start_[above + 1] - start_[above];
    for (std::uint32_t s = start_[above]; s < start_[above + 1]; ++s) {
      const Support& support = supports_[s];
      const double load = load_[above] / count;
      // What is higher has handed its load on already.
      if (support.below != Islands::none && height_[support.below] < height_[above]) load_[support.below] += load;
      const LoadedContact contact =
          loaded_contact(input.bodies, input.manifolds, {support.first, support.second, support.slot});
      check_load(contact, by_force * load / support.along, build, overloaded);
    }
  }
}

}  // namespace atl::solver
