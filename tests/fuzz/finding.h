#pragma once

#include <stdexcept>
#include <string>

namespace atl::fuzz {

/// What should not be. Nobody catches it but who runs many inputs: libFuzzer ends, and keeps the input.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void require(bool holds, const std::string& what) {
  if (!holds) throw Finding(what);
}

}  // namespace atl::fuzz
