#pragma once

#include <atoll/closed_form.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace atl::scene {

inline constexpr double max_error = 1e3;  // see ClosedFormMeasure::errors

/// The largest errors of a run so far, by name. "analytic_error" comes first, without a unit.
class LargestErrors {
 public:
  explicit LargestErrors(std::vector<ErrorMeasure> parts) : errors_(std::move(parts)) {
    errors_.insert(errors_.begin(), {"analytic_error"});
  }

  /// The name has to be one of those given. What is no number counts as the most.
  void raise(std::string_view name, double value) {
    const auto named = std::find_if(errors_.begin(), errors_.end(), [&](const auto& e) { return e.name == name; });
    named->value = std::max(named->value, value <= max_error ? value : max_error);
  }

  /// A part that counts in full.
  void raise_with_total(std::string_view name, double value) {
    raise(name, value);
    raise("analytic_error", value);
  }

  const std::vector<ErrorMeasure>& all() const { return errors_; }

 private:
  std::vector<ErrorMeasure> errors_;
};

}  // namespace atl::scene
