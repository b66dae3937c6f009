#pragma once
/// Faults as a careless change could bring them in, for what has to find them.

#include <atoll/atoll.h>

#include <vector>

#include "checks/divergence/variant_run.h"

namespace atl::test {

struct FaultPlace {
  std::int64_t step;
  std::size_t body;
};

/// Ahead of a step a body is faster by so many m/s along x if there are several threads.
inline divergence::Meddle more_speed_with_threads(FaultPlace place, double by = 1e-6) {
  return [=](World& world, const std::vector<BodyId>& ids, std::int64_t step, const divergence::Variant& variant) {
    if (step != place.step || variant.threads == 1) return;
    const BodyId id = ids[place.body];
    world.set_velocity(id, world.velocity(id) + Vector3(by, 0, 0), world.angular_velocity(id));
  };
}

/// Ahead of a step forces on a body add up in an order that depends on the number of threads.
inline divergence::Meddle order_of_forces_by_threads(FaultPlace place) {
  return [=](World& world, const std::vector<BodyId>& ids, std::int64_t step, const divergence::Variant& variant) {
    if (step != place.step) return;
    const bool reversed = variant.threads > 1;
    for (const double part : reversed ? std::vector{0.3, 0.2, 0.1} : std::vector{0.1, 0.2, 0.3}) {
      world.apply_force(ids[place.body], {part, 0, 0});
    }
  };
}

}  // namespace atl::test
