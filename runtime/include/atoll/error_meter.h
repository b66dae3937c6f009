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
    End,  ///< after the last step only: the scene's closed form and means over the run, which need all, are left out
  };

  /// Keeps a reference to the scene.
  explicit ErrorMeter(const Scene& scene, Follow follow = Follow::Run);

  /// True if observe() needs contact forces.
  bool needs_loads() const;

  /// In order; see ClosedFormMeasure::observe.
  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad> loads = {});

  /// Errors of the states last observed, and of the run. They come in this order, where they apply: analytic_error and
  /// its parts; joint_gap_run_mean, over joints and observed steps, and joint_gap_run_max; joint_drift_max,
  /// joint_drift_rms, joint_angle_max, joint_excess_max, joint_angle_excess_max; penetration_max, _p99, _mean,
  /// _max_relative, of pairs that may touch; sink_max, sink_mean, drift_max, tilt_max; energy_drift, unless springs or
  /// motors of joints have energy too; momentum_drift.
  std::vector<ErrorMeasure> errors() const;

  /// For a scene that starts at rest: true if some body left its place for good, tilted by more than 0.3 rad or drifted
  /// by more than its size (the cube root of its volume). Runs that fell must not be ranked by overlap, since a
  /// collapsed structure may overlap less than one that stands.
  bool fell() const;

 private:
  void add_joint_errors(std::vector<ErrorMeasure>& errors) const;
  MotionReport motion() const;

  /// Gaps of the joints' locked offsets, m.
  struct GapsOfRun {
    double mean_sum = 0;  ///< of the means of the steps
    double max = 0;
    int steps = 0;
  };

  const Scene& scene_;
  Follow follow_;
  std::unique_ptr<ClosedFormMeasure> closed_form_;
  std::vector<MassProperties> mass_;  ///< by dynamic body
  std::vector<BodyState> last_;
  MotionReport start_;
  std::vector<PlacedJoint> joints_;
  GapsOfRun gaps_;
};

}  // namespace atl
