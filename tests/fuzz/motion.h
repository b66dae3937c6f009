#pragma once

#include <atoll/errors.h>

#include <string>

#include "finding.h"

namespace atl::fuzz {

/// Requires the momentum of bodies that only act on each other to stay, but for so much (N s, N m s).
inline void require_same_momentum(const MotionReport& before, const MotionReport& after, double linear,
                                  double angular) {
  const double off = (after.momentum - before.momentum).norm();
  require(off <= linear, "momentum changes by " + std::to_string(off) + " of " + std::to_string(linear) + " N s");
  const double turn = (after.angular_momentum - before.angular_momentum).norm();
  require(turn <= angular,
          "angular momentum changes by " + std::to_string(turn) + " of " + std::to_string(angular) + " N m s");
}

}  // namespace atl::fuzz
