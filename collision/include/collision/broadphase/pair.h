#pragma once

#include <cstdint>
#include <vector>

namespace atl::collision {

/// Two shapes whose bounds overlap; first < second. Ordered as the key is.
struct Pair {
  std::uint32_t first;
  std::uint32_t second;

  static Pair of(std::uint32_t a, std::uint32_t b) { return a < b ? Pair{a, b} : Pair{b, a}; }
  static Pair of_key(std::uint64_t key) {
    return {static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)};
  }
  std::uint64_t key() const { return std::uint64_t{first} << 32 | second; }

  friend bool operator==(const Pair&, const Pair&) = default;
  friend bool operator<(const Pair& x, const Pair& y) { return x.key() < y.key(); }
};

/// Sorts pairs; `scratch` keeps its memory for the next time.
void sort_pairs(std::vector<Pair>& pairs, std::vector<Pair>& scratch);

}  // namespace atl::collision
