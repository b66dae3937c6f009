// A ball that bounces for ever.

#include "../analytic.h"
#include "largest_errors.h"
#include "setting.h"

namespace atl::scene {
namespace elastic_ball {

constexpr double radius = 0.5;   // m
constexpr double duration = 20;  // s

class ElasticBall : public ClosedFormMeasure {
 public:
  explicit ElasticBall(double height) : height_(height), period_(2 * std::sqrt(2 * height / standard_gravity)) {}

  // In contact an engine may keep energy where no one sees it, so each period counts by the most that was seen in it.
  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    const BodyState& state = states[1];
    const double energy =
        (state.pose.position.z() - radius + 0.5 * state.velocity.squaredNorm() / standard_gravity) / height_;
    const auto window = static_cast<std::size_t>(time / period_);
    if (periods_.size() <= window) periods_.resize(window + 1);
    Period& period = periods_[window];
    period.energy = std::max(period.energy, energy);
    period.lowest = std::min(period.lowest, (state.pose.position.z() - radius) / height_);
    time_ = time;
  }

  std::vector<ErrorMeasure> errors() const override {
    LargestErrors errors({{"energy_gain"}, {"energy_loss"}});
    for (std::size_t i = 0; i < periods_.size(); ++i) {
      const auto& [energy, lowest] = periods_[i];
      errors.raise_with_total("energy_gain", std::max(0.0, energy - 1));
      // The run may have ended in the middle of the last one, at an impact.
      const bool complete = time_ >= (static_cast<double>(i) + 0.75) * period_;
      if (!complete && i > 0) continue;
      // A ball that hangs in the air does not keep its energy.
      const bool bounced = lowest < 0.5 || !complete;
      errors.raise_with_total("energy_loss", bounced ? std::max(0.0, 1 - energy) : 1);
    }
    return errors.all();
  }

 private:
  struct Period {
    double energy = 0;  // the most, relative to that at the start
    double lowest = 1;  // height, relative to that at the start
  };

  double height_;
  double period_;    // s
  double time_ = 0;  // s
  std::vector<Period> periods_;
};

}  // namespace elastic_ball

Scene build_elastic_ball(const ParameterValues& values, std::uint64_t) {
  using namespace elastic_ball;
  Scene scene;
  scene.steps = steps_for(duration);
  scene.settings.restitution_threshold = 0.05;
  const Material elastic = {.friction = 0, .restitution = 1};
  const double height = values["height"];
  scene.bodies.push_back(plane(elastic));
  scene.bodies.push_back(solid("ball", Sphere{radius}, {0, 0, radius + height}, elastic));
  ClosedForm form;
  form.metric =
      "largest change of the mechanical energy, the most in each period of the bounce, relative to the start's";
  form.source = "conservation of energy";
  form.measure = [height] { return std::make_unique<ElasticBall>(height); };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
