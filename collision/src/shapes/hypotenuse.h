#pragma once

#include <algorithm>
#include <cmath>

namespace atl::collision {

/// sqrt(a^2 + b^2) without overflow, of finite numbers. C libraries round their hypot each in its own way; this is the
/// same to the bit everywhere.
inline double hypotenuse(double a, double b) {
  const double longer = std::max(std::abs(a), std::abs(b));
  if (!(longer > 0)) return longer;
  const double ratio = std::min(std::abs(a), std::abs(b)) / longer;
  return longer * std::sqrt(1 + ratio * ratio);
}

}  // namespace atl::collision
