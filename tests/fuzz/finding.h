#pragma once

#include <atoll/error.h>

#include <Eigen/Core>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

namespace atl::fuzz {

/// A violated invariant. Only the driver of many inputs catches it: libFuzzer ends, and keeps the input.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void require(bool holds, const std::string& what) {
  if (!holds) throw Finding(what);
}

/// Requires a call to throw Error with a message.
template <typename Call>
void require_refused(const std::string& what, const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return require(error.what()[0] != '\0', what + " is refused without a word");
  }
  throw Finding(what + " is not refused");
}

inline void require_finite(double value, const char* what) {
  require(std::isfinite(value), std::string(what) + " is " + std::to_string(value));
}
template <typename Derived>
std::string text_of(const Eigen::DenseBase<Derived>& values) {
  std::ostringstream out;
  out.precision(17);
  out << values.derived().transpose();
  return out.str();
}
template <typename Derived>
void require_finite(const Eigen::DenseBase<Derived>& values, const char* what) {
  require(values.allFinite(), std::string(what) + " is " + text_of(values));
}

}  // namespace atl::fuzz
