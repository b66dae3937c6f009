#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace atl::view {

/// Rounds a number to an integer for a film, within +-2^29: predictions from two such numbers then fit into 32 bits.
inline std::int32_t rounded(double value) {
  constexpr double farthest = 1 << 29;
  // Beside this number doubles are whole: a sum with it is rounded, which takes an eighth of what lround() does.
  constexpr double whole = 6755399441055744.0;  // 1.5 * 2^52
  return std::isfinite(value) ? static_cast<std::int32_t>(std::clamp(value, -farthest, farthest) + whole - whole) : 0;
}

/// Codes a force (N, >= 0) by twelfths of a doubling: a byte holds 0.06 N to 2 MN.
inline std::uint8_t force_code(double force) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(12 * std::log2(1 + force)), 0l, 255l));
}

}  // namespace atl::view
