#pragma once

#include <atoll/world.h>

#include <vector>

namespace atl::tradeoff {

/// The contact residual of every step of a run, relative; see measure_contact_residual. The world has to keep its
/// contact problem.
class ResidualMeter {
 public:
  void observe(const World& world);

  // Statistics of the steps so far; there must be at least one.
  double last() const { return by_step_.back(); }
  double median() const;  ///< the upper of the middle two
  double max() const;

 private:
  std::vector<double> by_step_;
};

}  // namespace atl::tradeoff
