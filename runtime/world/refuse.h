#pragma once

#include <atoll/error.h>
#include <atoll/types.h>

#include <Eigen/Core>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>

#include "world/utf8.h"

namespace atl {

/// Throws Error: the field, the value that it has, a number or a vector, and what was expected.
template <typename Value>
[[noreturn]] void refuse(std::string_view field, const Value& found, std::string_view expected) {
  std::ostringstream message;
  message << field << " is ";
  if constexpr (std::is_arithmetic_v<Value>) {
    message << found;
  } else {
    const Eigen::IOFormat flat(Eigen::StreamPrecision, Eigen::DontAlignCols, ", ", "; ", "", "", "(", ")");
    message << found.reshaped(1, found.size()).format(flat);
  }
  message << "; expected " << expected;
  throw Error(message.str());
}

/// Throws Error: `call` was given the id of a body that there is no longer, or never was.
[[noreturn]] inline void refuse_stale(std::string_view call, BodyId id) {
  std::ostringstream message;
  message << call << ": no body has the id (index " << id.index << ", generation " << id.generation
          << "); expected the id of a body that has not been removed";
  throw Error(message.str());
}

/// Refuses a name that scene files and pages can't hold. The message doesn't repeat it either.
inline void check_name(std::string_view field, std::string_view name) {
  if (is_name(name)) return;
  if (is_utf8(name)) throw Error(std::string(field) + " has control characters; expected text without them");
  std::ostringstream message;
  message << field << " has " << name.size() << " bytes that are not UTF-8; expected text that is";
  throw Error(message.str());
}

inline void check_finite(std::string_view field, double value) {
  if (!std::isfinite(value)) refuse(field, value, "a finite number");
}
inline void check_finite(std::string_view field, const Vector3& value) {
  if (!value.allFinite()) refuse(field, value, "three finite numbers");
}

/// Sizes that single precision can compute with in a step: products of two such numbers, and of one and the inverse of
/// another, neither overflow nor lose digits.
struct Bounds {
  double min, max;
};
inline constexpr Bounds numbers{1e-15, 1e15};
/// Bounds of masses, stiffnesses and the loads that break a joint. They are wider, since lengths and times multiply
/// them.
inline constexpr Bounds loads{1e-30, 1e30};

[[noreturn]] inline void refuse_size(std::string_view field, const auto& value, double bound, const char* side) {
  std::ostringstream expected;
  expected << "a size of at " << side << " " << bound << ", with which single precision can compute";
  refuse(field, value, expected.str());
}

inline void check_positive(std::string_view field, double value, const Bounds& bounds = numbers) {
  if (!(std::isfinite(value) && value > 0)) refuse(field, value, "a finite number above 0");
  if (value < bounds.min) refuse_size(field, value, bounds.min, "least");
  if (value > bounds.max) refuse_size(field, value, bounds.max, "most");
}

inline void check_not_negative(std::string_view field, double value, const Bounds& bounds = numbers) {
  if (!(std::isfinite(value) && value >= 0)) refuse(field, value, "a finite number not below 0");
  if (value > bounds.max) refuse_size(field, value, bounds.max, "most");
}

/// One of either sign.
inline void check_number(std::string_view field, double value, const Bounds& bounds = numbers) {
  check_finite(field, value);
  if (std::abs(value) > bounds.max) refuse_size(field, value, bounds.max, "most");
}
inline void check_number(std::string_view field, const Vector3& value, const Bounds& bounds = numbers) {
  check_finite(field, value);
  if (value.cwiseAbs().maxCoeff() > bounds.max) refuse_size(field, value, bounds.max, "most");
}

}  // namespace atl
