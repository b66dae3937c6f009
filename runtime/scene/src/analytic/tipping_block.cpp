// Tall blocks pushed through their centres, below and above what tips them over an edge.

#include <array>

#include "../analytic.h"
#include "largest_errors.h"
#include "pivot.h"

namespace atl::scene {
namespace tipping_block {

constexpr double duration = 1.5;                          // s
constexpr double half_width = 0.25;                       // m
constexpr double last_tilt = 0.5;                         // rad, how far a fall is followed
constexpr std::array ratios = {0.5, 0.9, 1.1, 1.3, 1.6};  // of the push to what tips
constexpr Material rough = {.friction = 1.5};             // edges do not slip

class TippingBlocks : public ClosedFormMeasure {
 public:
  explicit TippingBlocks(double half_height) : errors_({{"hold_error"}, {"tip_error"}}) {
    for (const double ratio : ratios)
      falls_.emplace_back(Pivot(half_width, half_height, ratio * half_width / half_height));
  }

  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    for (std::size_t i = 0; i < ratios.size(); ++i) {
      const double tilt = tilt_towards_x(states[i + 1]);
      if (ratios[i] < 1) {
        errors_.raise_with_total("hold_error", std::abs(tilt) / last_tilt);
      } else if (const double expected = falls_[i].tilt(time); expected <= last_tilt) {
        errors_.raise_with_total("tip_error", std::abs(tilt - expected) / last_tilt);
      }
    }
  }
  std::vector<ErrorMeasure> errors() const override { return errors_.all(); }

 private:
  std::vector<PivotMotion> falls_;
  LargestErrors errors_;
};

}  // namespace tipping_block

Scene build_tipping_block(const ParameterValues& values, std::uint64_t) {
  using namespace tipping_block;
  const double half_height = values["slenderness"] * half_width;
  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(plane(rough));
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    SceneBody block = solid(numbered("block", static_cast<int>(i)), Box{{half_width, half_width, half_height}},
                            {0, static_cast<double>(i), half_height}, rough);
    const double weight = body_mass(block.def).mass * standard_gravity;
    block.force = {ratios[i] * weight * half_width / half_height, 0, 0};
    scene.bodies.push_back(block);
  }
  ClosedForm form;
  form.metric = "largest difference of a block's tilt from the closed form's, relative to 0.5 rad, up to that tilt";
  form.source = "tips where F h > m g w, with I w' = F R cos(a - tilt) - m g R sin(a - tilt) about the edge";
  form.measure = [half_height] { return std::make_unique<TippingBlocks>(half_height); };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
