// The measures of the scenes with joints: motions integrated here have no error, wrong ones the error that they should.

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <numbers>

#include "support/closed_form_run.h"

namespace atl::test {
namespace {

/// x'' = f(x, x') by the classical method of Runge and Kutta, in steps of at most 0.1 ms.
template <class Acceleration>
std::pair<double, double> integrated(double x, double t, const Acceleration& f) {
  double v = 0;
  const int steps = static_cast<int>(std::ceil(t / 1e-4));
  const double h = t / steps;
  for (int i = 0; i < steps; ++i) {
    const double v1 = v, a1 = f(x, v1);
    const double v2 = v + h / 2 * a1, a2 = f(x + h / 2 * v1, v2);
    const double v3 = v + h / 2 * a2, a3 = f(x + h / 2 * v2, v3);
    const double v4 = v + h * a3, a4 = f(x + h * v3, v4);
    x += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {x, v};
}

void hang_rod(BodyState& state, double angle, double rate) {
  state.pose.position = Vector3(std::sin(angle), 0, -std::cos(angle)) / 2;
  state.pose.orientation = Quaternion(Eigen::AngleAxisd(angle, -Vector3::UnitY()));
  state.angular_velocity = {0, -rate, 0};
}

TEST(ClosedForm, PendulumByRungeAndKutta) {
  for (const double released : {0.3, 2.0, 3.0}) {
    const Scene scene = load_scene("pendulum:angle=" + std::to_string(released));
    const double width = 0.06;  // m; I / m of a rod of 1 m about its end
    const double inertia = 1.0 / 3 + width * width / 12;
    const auto swinging = [&](double factor) {
      return errors_of(
          scene,
          [&](double t, std::vector<BodyState>& states) {
            const auto [angle, rate] =
                integrated(released, t, [&](double x, double) { return -g / 2 / inertia * std::sin(x); });
            hang_rod(states[1], factor * angle, factor * rate);
          },
          1.0 / 15);
    };
    for (const auto& [name, error] : swinging(1)) EXPECT_LT(error, 1e-9) << name << " from " << released;
    EXPECT_NEAR(swinging(0.99).at("analytic_error"), 0.01, 1e-3);
  }
}

TEST(ClosedForm, SpringsByRungeAndKutta) {
  const Scene scene = load_scene("spring-damper:hertz=0.7");
  const double w = 2 * std::numbers::pi * 0.7, lift = 0.3;
  constexpr std::array ratios = {0.0, 0.2, 1.0, 3.0, 0.2};
  const auto with = [&](double more) {
    return errors_of(
        scene,
        [&](double t, std::vector<BodyState>& states) {
          for (std::size_t i = 0; i < ratios.size(); ++i) {
            const auto [x, v] =
                integrated(lift, t, [&](double y, double u) { return -w * w * y - 2 * ratios[i] * w * u; });
            // Below where the spring is at rest by the weight over the stiffness.
            states[2 * i + 1].pose.position.z() = -2 - g / (w * w) + x + more;
          }
        },
        1.0 / 15);
  };
  for (const auto& [name, error] : with(0)) EXPECT_LT(error, 1e-9) << name;
  for (const auto& [name, error] : with(0.003)) EXPECT_NEAR(error, 0.01, 1e-9) << name;
}

TEST(ClosedForm, SliderCrankClosesItsTriangle) {
  const Scene scene = load_scene("slider-crank:speed=4,rod=2");
  const auto turning = [&](double late) {
    return errors_of(
        scene,
        [&](double t, std::vector<BodyState>& states) {
          const double angle = 4 * t - late;
          states[1].pose.orientation = Quaternion(Eigen::AngleAxisd(angle, -Vector3::UnitY()));
          // By the law of sines: the rod's own angle.
          const double rod = std::asin(std::sin(angle) / 2);
          states[3].pose.position = {0.25 * std::cos(angle) + 0.5 * std::cos(rod), 0, 0};
        },
        1.0 / 60);
  };
  for (const auto& [name, error] : turning(0)) EXPECT_LT(error, 1e-9) << name;
  EXPECT_NEAR(turning(0.01).at("crank_error"), 0.01, 1e-9);
  EXPECT_LT(turning(0.01).at("closure_error"), 1e-9);
  EXPECT_GT(turning(0.01).at("analytic_error"), 5e-3);
}

// Small swings are sums of two modes.
TEST(ClosedForm, DoublePendulumByItsModes) {
  const Scene scene = load_scene("double-pendulum:angle=0.02");
  const double l1 = 1, l2 = 0.7, m1 = l1, m2 = l2, side = 0.06;
  const double i1 = m1 * (l1 * l1 / 3 + side * side / 12), i2 = m2 * (l2 * l2 / 3 + side * side / 12);
  Eigen::Matrix2d mass, stiffness;
  mass << i1 + m2 * l1 * l1, m2 * l1 * l2 / 2, m2 * l1 * l2 / 2, i2;
  stiffness << g * (m1 * l1 / 2 + m2 * l1), 0, 0, g * m2 * l2 / 2;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> modes(stiffness, mass);
  const Eigen::Vector2d start = modes.eigenvectors().transpose() * mass * Eigen::Vector2d::Constant(0.02);
  const Errors errors = errors_of(
      scene,
      [&](double t, std::vector<BodyState>& states) {
        const Eigen::Vector2d phase = (modes.eigenvalues().cwiseSqrt() * t).array().cos().matrix();
        const Eigen::Vector2d angle = modes.eigenvectors() * start.cwiseProduct(phase);
        const Vector3 first(std::sin(angle[0]), 0, -std::cos(angle[0]));
        const Vector3 second(std::sin(angle[1]), 0, -std::cos(angle[1]));
        states[1].pose.position = l1 / 2 * first;
        states[2].pose.position = l1 * first + l2 / 2 * second;
      },
      1.0 / 60);
  // The linear modes neglect the cube of the angle: 0.02^3 / 6 a radian of phase.
  EXPECT_LT(errors.at("analytic_error"), 2e-5);
}

}  // namespace
}  // namespace atl::test
