#pragma once

#include <atoll/closed_form.h>
#include <atoll/errors.h>
#include <atoll/scene.h>

#include <memory>
#include <span>
#include <vector>

namespace atl {

/// Measures a run of a scene from what any engine can tell: the states of its bodies. The same code, and so the same
/// errors, for Atoll and for the engines that it is compared with.
class ErrorMeter {
 public:
  enum class Follow {
    Run,  ///< observe() is called after every step
    End,  ///< after the last step only: the scene's closed form, which may need all steps, is left out
  };

  /// Keeps a reference to the scene.
  explicit ErrorMeter(const Scene& scene, Follow follow = Follow::Run);

  /// Whether observe() needs contact forces.
  bool needs_loads() const;

  /// In order; see ClosedFormMeasure::observe.
  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad> loads = {});

  /// Of the states last observed, and of the run. In this order, where they apply: analytic_error and its parts;
  /// penetration_max, _p99, _mean, _max_relative; sink_max, sink_mean, drift_max, tilt_max; energy_drift;
  /// momentum_drift.
  std::vector<ErrorMeasure> errors() const;

  /// Of a scene that starts at rest: whether some body left its place for good, tilted by more than 0.3 rad or drifted
  /// by more than its size, the cube root of its volume. What has collapsed may overlap less than what stands.
  bool fell() const;

 private:
  MotionReport motion() const;

  const Scene& scene_;
  std::unique_ptr<ClosedFormMeasure> closed_form_;
  std::vector<MassProperties> mass_;  ///< by dynamic body
  std::vector<BodyState> last_;
  MotionReport start_;
};

}  // namespace atl
