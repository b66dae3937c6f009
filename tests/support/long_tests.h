#pragma once

#include <cstddef>
#include <cstdlib>
#include <string_view>
#include <vector>

namespace atl::test {

/// True if the heavier matrix was asked for: ATOLL_LONG_TESTS=1, or tests/run.sh --long.
inline bool long_tests() {
  const char* value = std::getenv("ATOLL_LONG_TESTS");
  return value != nullptr && std::string_view(value) == "1";
}

/// Places in a file to spoil: the first 100, where its header is, then each seventh, which falls on all bits and bytes
/// of fields in turn, and the last one. All in long tests.
inline std::vector<std::size_t> bytes_to_try(std::size_t size) {
  constexpr std::size_t header = 100, step = 7;
  std::vector<std::size_t> places;
  for (std::size_t at = 0; at < size; at += long_tests() || at < header ? 1 : step) places.push_back(at);
  if (!places.empty() && places.back() != size - 1) places.push_back(size - 1);
  return places;
}

}  // namespace atl::test
