// Two rods, one hinged to the end of the other, that swing from rest.

#include <array>

#include "../analytic.h"
#include "largest_errors.h"
#include "rod.h"

namespace atl::scene {
namespace double_pendulum {

constexpr double duration = 2.5;            // s: later a small difference would have grown too much
constexpr std::array lengths = {1.0, 0.7};  // m

/// Angles from hanging straight down, and their rates: Lagrange's equations of two rods (as in Goldstein, "Classical
/// Mechanics", chapter 1, of points), by the classical method of Runge and Kutta in steps of at most 0.1 ms, whose
/// error is below 1e-10 rad.
class DoublePendulum {
 public:
  using Two = Eigen::Vector2d;

  DoublePendulum(const std::array<MassProperties, 2>& mass, double released) : angle_(Two::Constant(released)) {
    const auto own = [&](std::size_t i) { return mass[i].inertia(1, 1) + mass[i].mass * lengths[i] * lengths[i] / 4; };
    first_ = own(0) + mass[1].mass * lengths[0] * lengths[0];
    second_ = own(1);
    coupling_ = mass[1].mass * lengths[0] * lengths[1] / 2;
    weight_ = standard_gravity *
              Two(mass[0].mass * lengths[0] / 2 + mass[1].mass * lengths[0], mass[1].mass * lengths[1] / 2);
  }

  /// At a time (s) not before that of the last call.
  Two angle(double time) {
    const int steps = static_cast<int>(std::ceil((time - time_) / 1e-4));
    const double h = steps > 0 ? (time - time_) / steps : 0;
    for (int i = 0; i < steps; ++i) step(h);
    time_ = time;
    return angle_;
  }

 private:
  Two acceleration(const Two& angle, const Two& rate) const {
    const double mixed = coupling_ * std::cos(angle[0] - angle[1]);
    const double pull = coupling_ * std::sin(angle[0] - angle[1]);
    const Two force(-pull * rate[1] * rate[1] - weight_[0] * std::sin(angle[0]),
                    pull * rate[0] * rate[0] - weight_[1] * std::sin(angle[1]));
    const double determinant = first_ * second_ - mixed * mixed;
    return Two(second_ * force[0] - mixed * force[1], first_ * force[1] - mixed * force[0]) / determinant;
  }

  void step(double h) {
    const Two v1 = rate_, a1 = acceleration(angle_, v1);
    const Two v2 = rate_ + h / 2 * a1, a2 = acceleration(angle_ + h / 2 * v1, v2);
    const Two v3 = rate_ + h / 2 * a2, a3 = acceleration(angle_ + h / 2 * v2, v3);
    const Two v4 = rate_ + h * a3, a4 = acceleration(angle_ + h * v3, v4);
    angle_ += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    rate_ += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }

  double first_ = 0, second_ = 0, coupling_ = 0;  // kg m^2
  Two weight_ = Two::Zero();                      // N m, at right angles
  Two angle_;
  Two rate_ = Two::Zero();
  double time_ = 0;
};

class DoublePendulumMeasure : public ClosedFormMeasure {
 public:
  explicit DoublePendulumMeasure(const DoublePendulum& expected)
      : expected_(expected), errors_({{"first_error"}, {"second_error"}, {"off_plane", 0, "m"}}) {}

  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    const Eigen::Vector2d angle = expected_.angle(time);
    Vector3 top = Vector3::Zero();
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      const Vector3 along(std::sin(angle[static_cast<int>(i)]), 0, -std::cos(angle[static_cast<int>(i)]));
      const Vector3 centre = states[i + 1].pose.position;
      errors_.raise_with_total(i == 0 ? "first_error" : "second_error",
                               (centre - top - lengths[i] / 2 * along).norm() / (lengths[0] + lengths[1]));
      errors_.raise("off_plane", std::abs(centre.y()));
      top += lengths[i] * along;
    }
  }
  std::vector<ErrorMeasure> errors() const override { return errors_.all(); }

 private:
  DoublePendulum expected_;
  LargestErrors errors_;
};

}  // namespace double_pendulum

Scene build_double_pendulum(const ParameterValues& values, std::uint64_t) {
  using namespace double_pendulum;
  const double released = values["angle"];
  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(untouched(fixed_ball("hook", Vector3::Zero(), 0.05)));
  Vector3 top = Vector3::Zero();
  std::array<MassProperties, 2> mass;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const SceneBody rod = hanging_rod(numbered("rod", static_cast<int>(i)), lengths[i], top, released);
    mass[i] = body_mass(rod.def);
    scene.bodies.push_back(rod);
    join_last_two(scene, HingeJoint{}, top, swinging());
    top = rod.def.position - rod.def.orientation * Vector3(0, 0, lengths[i] / 2);
  }
  ClosedForm form;
  form.metric = "largest distance of a rod's centre from its place in the reference, relative to both rods' length";
  form.source = "Lagrange's equations, integrated by a Runge-Kutta method of fourth order in steps of 0.1 ms";
  form.measure = [expected = DoublePendulum(mass, released)] {
    return std::make_unique<DoublePendulumMeasure>(expected);
  };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
