#include <solver/constraints/load_check.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

struct Size {
  double arm, half_thickness;  // m
};

Size size_at(const float (&normal)[3], const float (&anchor)[3], double inverse_mass) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (inverse_mass == 0) return {infinite, infinite};
  const Vector3 arm = get3(anchor);
  return {arm.norm(), std::max(std::abs(get3(normal).dot(arm)), tuning::least_thickness * arm.norm())};
}

}  // namespace

double load_of(const collision::ContactManifold& manifold) {
  double load = 0;
  for (const float impulse : manifold.normal_impulse) load += collision::kept_impulse(impulse);
  return load;
}

void check_load(const LoadedContact& contact, double penetration, Build build,
                std::vector<OverloadedBody>& overloaded) {
  // Contacts are twice as fast, four times as stiff, against what doesn't respond.
  const double softness = contact.inverse_first == 0 || contact.inverse_second == 0 ? 0.25 : 1;
  const double estimate = softness * penetration * (contact.inverse_first + contact.inverse_second);
  const collision::ContactManifold& manifold = contact.manifold;
  const Size first = size_at(manifold.normal, manifold.anchor_first, contact.inverse_first);
  const Size second = size_at(manifold.normal, manifold.anchor_second, contact.inverse_second);
  const double allowed = build == Build::Columns ? tuning::column_penetration : tuning::overload_penetration;
  if (!(estimate > allowed * std::min(first.half_thickness, second.half_thickness))) return;
  const bool first_lighter = contact.inverse_first >= contact.inverse_second;
  const auto [heavy, light] = std::minmax(contact.inverse_first, contact.inverse_second);
  const bool deep = build == Build::Joined ? heavy > 0 && light >= tuning::deep_ratio * heavy
                                           : estimate > tuning::deep_penetration * std::min(first.arm, second.arm);
  overloaded.push_back({first_lighter ? contact.first : contact.second, deep});
}

}  // namespace atl::solver
