// A slender block that rocks from edge to edge and loses energy each time it lands.

#include <numeric>

#include "../analytic.h"
#include "largest_errors.h"
#include "pivot.h"

namespace atl::scene {
namespace rocking_block {

constexpr double half_width = 0.2;           // m
constexpr int peaks = 4;                     // that are compared
constexpr Material rough = {.friction = 1};  // edges do not slip

struct Peak {
  double time;  // s
  double tilt;  // rad, to either side
};

// Angular momentum about the new edge is the same before and after landing: the rate falls by 1 - 3/2 sin^2(a).
std::vector<Peak> rocking_peaks(const Pivot& pivot, double released) {
  const double kept = 1 - 1.5 * std::pow(std::sin(pivot.slenderness()), 2);
  std::vector<Peak> all = {{0, released}};
  for (int i = 0; i < peaks; ++i) {
    const Peak last = all.back();
    const double landing =
        2 * pivot.rate() * std::sqrt(std::sin(pivot.slenderness() - last.tilt / 2) * std::sin(last.tilt / 2));
    const double tilt = pivot.peak(0, kept * landing);
    all.push_back({last.time + pivot.quarter_period(last.tilt) + pivot.quarter_period(tilt), tilt});
  }
  return all;
}

class RockingBlock : public ClosedFormMeasure {
 public:
  RockingBlock(const Pivot& pivot, double released) : pivot_(pivot), expected_(rocking_peaks(pivot, released)) {}

  // A peak lies where the rate changes its sign: on the left from negative, on the right from positive.
  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    const BodyState& state = states[1];
    const double tilt = tilt_towards_x(state), rate = state.angular_velocity.y();
    const double side = found_.size() % 2 == 0 ? -1 : 1;
    if (found_.size() < peaks && side * rate_ > 0 && side * rate <= 0 && side * tilt > 0) {
      const bool before = std::abs(rate_) < std::abs(rate) && side * tilt_ > 0;
      const double at = time_ + (time - time_) * rate_ / (rate_ - rate);
      found_.push_back({at, before ? pivot_.peak(side * tilt_, rate_) : pivot_.peak(side * tilt, rate)});
    }
    time_ = time;
    tilt_ = tilt;
    rate_ = rate;
  }

  std::vector<ErrorMeasure> errors() const override {
    LargestErrors errors({{"peak_error"}, {"time_error"}});
    for (std::size_t i = 0; i < peaks; ++i) {
      const Peak& peak = expected_[i + 1];
      const bool known = i < found_.size();
      errors.raise_with_total("peak_error",
                              (known ? std::abs(found_[i].tilt - peak.tilt) : peak.tilt) / expected_[0].tilt);
      errors.raise_with_total("time_error", known ? std::abs(found_[i].time / peak.time - 1) : 1);
    }
    return errors.all();
  }

 private:
  Pivot pivot_;
  std::vector<Peak> expected_;  // the release first
  std::vector<Peak> found_;
  double time_ = 0;
  double tilt_ = 0;
  double rate_ = 0;
};

}  // namespace rocking_block

Scene build_rocking_block(const ParameterValues& values, std::uint64_t) {
  using namespace rocking_block;
  const double half_height = values["slenderness"] * half_width;
  const Pivot pivot(half_width, half_height);
  const double released = values["release"] * pivot.slenderness();

  Scene scene;
  scene.steps = steps_for(1.05 * rocking_peaks(pivot, released).back().time);
  scene.bodies.push_back(plane(rough));
  const Quaternion orientation = turned(released, Vector3::UnitY());
  const Vector3 edge(half_width, 0, 0);
  SceneBody block = solid("block", Box{{half_width, 2 * half_width, half_height}},
                          edge + orientation * Vector3(-half_width, 0, half_height), rough);
  block.def.orientation = orientation;
  scene.bodies.push_back(block);

  ClosedForm form;
  form.metric =
      "over the first four times that it comes to rest: largest difference of the tilt from the closed "
      "form's, relative to that at release, and of the time, relative to that since release";
  form.source = "Housner, The behavior of inverted pendulum structures during earthquakes, 1963, with exact angles";
  form.measure = [=] { return std::make_unique<RockingBlock>(pivot, released); };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
