#pragma once

#include <atoll/types.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace atl {

/// A figure of merit of a run; smaller is better.
struct ErrorMeasure {
  std::string name;  ///< as "analytic_error"
  double value = 0;
  std::string unit = {};  ///< "m", "rad", or "" for a ratio
};

/// Force between two bodies of a scene, over all points where they touch.
struct ContactLoad {
  std::size_t a = 0;  ///< place in the scene's list of bodies
  std::size_t b = 0;
  Vector3 force = Vector3::Zero();  ///< N, world frame, of a on b, as of the end of a step
};

/// Follows one run of a scene, by whatever engine, and compares it with the closed form.
class ClosedFormMeasure {
 public:
  virtual ~ClosedFormMeasure() = default;

  /// Called after each step, in order. `time` is in s since the start; `states` holds the scene's bodies in order, all
  /// finite. `loads` is empty unless the closed form asks for it.
  virtual void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad> loads) = 0;

  /// Errors over all that was observed. The first is "analytic_error", relative to the scene's scale (see
  /// ClosedForm::metric); others may split it up. Finite and >= 0; at most 1e3, which also stands for a motion of the
  /// wrong kind.
  virtual std::vector<ErrorMeasure> errors() const = 0;
};

/// The closed form of a scene whose motion is known.
struct ClosedForm {
  std::string metric = {};   ///< in words: what is compared, and relative to what
  std::string source = {};   ///< of the formula
  bool needs_loads = false;  ///< the measure looks at contact forces
  std::function<std::unique_ptr<ClosedFormMeasure>()> measure = {};
};

}  // namespace atl
