#include "checks/tradeoff/residual_meter.h"

#include <atoll/errors.h>

#include <algorithm>

namespace atl::tradeoff {

void ResidualMeter::observe(const World& world) {
  by_step_.push_back(measure_contact_residual(world.contact_problem()).relative);
}

double ResidualMeter::median() const {
  std::vector<double> sorted = by_step_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

double ResidualMeter::max() const { return *std::max_element(by_step_.begin(), by_step_.end()); }

}  // namespace atl::tradeoff
