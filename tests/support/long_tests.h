#pragma once

#include <cstdlib>
#include <string_view>

namespace atl::test {

/// Whether the heavier matrix was asked for: ATOLL_LONG_TESTS=1, or tests/run.sh --long.
inline bool long_tests() {
  const char* value = std::getenv("ATOLL_LONG_TESTS");
  return value != nullptr && std::string_view(value) == "1";
}

}  // namespace atl::test
