#pragma once

#include <atoll/body_hash.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace atl {

struct Stores;

/// By body index; zero where there is none.
std::vector<BodyHash> body_hashes(const Stores& world);
BodyHash body_hash(const Stores& world, std::uint32_t body);

/// Names of the parts of a body's hash, for reports of a difference.
inline constexpr std::array body_parts = {
    std::pair{"pose", &BodyHash::pose},     std::pair{"velocity", &BodyHash::velocity},
    std::pair{"forces", &BodyHash::input},  std::pair{"rest", &BodyHash::rest},
    std::pair{"bounds", &BodyHash::bounds}, std::pair{"contacts", &BodyHash::contacts},
    std::pair{"joints", &BodyHash::joints}};

/// Nine bits a part: of 512 changes of it one doesn't show.
inline constexpr int bits_of_part = 9;
static_assert(body_parts.size() * bits_of_part <= 64);

inline std::uint64_t fold(const BodyHash& hash) {
  std::uint64_t word = 0;
  for (const auto& [name, part] : body_parts) word = word << bits_of_part | (hash.*part >> (64 - bits_of_part));
  return word;
}

/// Names of the parts in which two bodies differ, in order.
inline std::vector<std::string> differing_parts(std::uint64_t a, std::uint64_t b) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < body_parts.size(); ++i) {
    const int at = bits_of_part * static_cast<int>(body_parts.size() - 1 - i);
    if ((a >> at & ((1u << bits_of_part) - 1)) != (b >> at & ((1u << bits_of_part) - 1))) {
      names.emplace_back(body_parts[i].first);
    }
  }
  return names;
}

}  // namespace atl
