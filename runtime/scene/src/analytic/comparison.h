#pragma once

#include <atoll/closed_form.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "largest_errors.h"

namespace atl::scene {

/// Compares one state of a scene with the closed form at that time, in s.
using Compare = std::function<void(double time, std::span<const BodyState> states, LargestErrors& errors)>;

/// Compares every state by itself, and keeps the largest errors.
class Comparison : public ClosedFormMeasure {
 public:
  Comparison(std::vector<ErrorMeasure> parts, Compare compare)
      : errors_(std::move(parts)), compare_(std::move(compare)) {}

  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    compare_(time, states, errors_);
  }
  std::vector<ErrorMeasure> errors() const override { return errors_.all(); }

 private:
  LargestErrors errors_;
  Compare compare_;
};

/// A closed form that gives the state at any time.
inline ClosedForm known_motion(std::string metric, std::string source, std::vector<ErrorMeasure> parts,
                               Compare compare) {
  ClosedForm form;
  form.metric = std::move(metric);
  form.source = std::move(source);
  form.measure = [parts = std::move(parts), compare = std::move(compare)]() -> std::unique_ptr<ClosedFormMeasure> {
    return std::make_unique<Comparison>(parts, compare);
  };
  return form;
}

}  // namespace atl::scene
