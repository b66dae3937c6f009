#pragma once

#include <atoll/settings.h>

#include <array>
#include <utility>

namespace atl {

/// Names of the instruction sets in kernels, options and reports.
inline constexpr std::array simd_names = {std::pair{Simd::Auto, "auto"},     std::pair{Simd::Portable, "portable"},
                                          std::pair{Simd::Sse4, "sse4"},     std::pair{Simd::Avx2, "avx2"},
                                          std::pair{Simd::Avx512, "avx512"}, std::pair{Simd::Neon, "neon"}};

inline const char* name_of(Simd simd) {
  for (const auto& [set, name] : simd_names) {
    if (set == simd) return name;
  }
  return "unknown";
}

}  // namespace atl
