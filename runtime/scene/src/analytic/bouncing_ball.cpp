// A ball that bounces with a restitution below 1: each apex is e^2 as high as the one before.

#include "../analytic.h"
#include "largest_errors.h"
#include "setting.h"

namespace atl::scene {
namespace bouncing_ball {

constexpr double radius = 0.5;  // m
constexpr int bounces = 3;

class BouncingBall : public ClosedFormMeasure {
 public:
  BouncingBall(double height, double restitution) : height_(height), restitution_(restitution) {}

  // An apex lies between a step upwards and one downwards; from either the flight tells how high it is.
  void observe(double, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    const BodyState& state = states[1];
    const double rising = state.velocity.z();
    const double reaches = state.pose.position.z() - radius + 0.5 * rising * rising / standard_gravity;
    if (rising_ > 0 && rising <= 0) apexes_.push_back(rising_ < -rising ? reaches_ : reaches);
    rising_ = rising;
    reaches_ = reaches;
  }

  std::vector<ErrorMeasure> errors() const override {
    LargestErrors errors({{"bounce_error"}});
    double expected = height_, last = height_;
    for (std::size_t i = 0; i < bounces; ++i) {
      const double apex = i < apexes_.size() ? apexes_[i] : 0;
      expected *= restitution_ * restitution_;
      errors.raise("analytic_error", std::abs(apex - expected) / height_);
      const double ratio = last > 0 ? std::sqrt(std::max(0.0, apex / last)) : 0;
      errors.raise("bounce_error", std::abs(ratio / restitution_ - 1));
      last = apex;
    }
    return errors.all();
  }

 private:
  double height_;
  double restitution_;
  double rising_ = 0;   // m/s
  double reaches_ = 0;  // m
  std::vector<double> apexes_;
};

}  // namespace bouncing_ball

Scene build_bouncing_ball(const ParameterValues& values, std::uint64_t) {
  using namespace bouncing_ball;
  const double height = values["height"], restitution = values["restitution"];
  const double fall = std::sqrt(2 * height / standard_gravity);
  double last_apex = fall, rise = fall;  // s
  for (int i = 0; i < bounces; ++i) {
    if (i > 0) last_apex += rise;
    rise *= restitution;
    last_apex += rise;
  }

  Scene scene;
  // Past the last apex by far less than the ball needs to come down from it.
  scene.steps = steps_for(last_apex + rise / 2);
  scene.settings.restitution_threshold = 0.05;
  const Material bouncy = {.friction = 0, .restitution = restitution};
  scene.bodies.push_back(plane(bouncy));
  scene.bodies.push_back(solid("ball", Sphere{radius}, {0, 0, radius + height}, bouncy));
  ClosedForm form;
  form.metric =
      "largest difference of the first three apexes from e^(2n) h, relative to h; bounce_error is that of the "
      "speeds' ratio, relative to e";
  form.source = "Newton's restitution: an impact leaves e of the speed, and e^2 of the height";
  form.measure = [=] { return std::make_unique<BouncingBall>(height, restitution); };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
