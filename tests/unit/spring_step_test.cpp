// A spring's map from step to step against the closed form.

#include <gtest/gtest.h>
#include <solver/constraints/spring_step.h>
#include <solver/integrate/trigonometry.h>

#include <cmath>
#include <complex>

namespace atl::solver {
namespace {

// x'' + decay x' + omega^2 x = 0 from x = 1 at rest.
double oscillation(double omega, double decay, double t) {
  const std::complex<double> root = std::sqrt(std::complex<double>(0.25 * decay * decay - omega * omega));
  const std::complex<double> a = -0.5 * decay + root, b = -0.5 * decay - root;
  if (std::abs(a - b) < 1e-9) return (std::exp(a * t) * (1.0 - a * t)).real();
  return ((a * std::exp(b * t) - b * std::exp(a * t)) / (a - b)).real();
}

TEST(SpringStep, TakesPositionsToThoseOfTheClosedForm) {
  const double h = 0.01;
  for (const double omega : {0.0, 1e-3, 1.0, 30.0, 99.0}) {
    for (const double decay : {0.0, 1e-3, 1.0, 60.0, 500.0, 1e5}) {
      const SpringStep map = SpringStep::of(omega, decay, h);
      // Two positions of the motion give the third.
      const double before = oscillation(omega, decay, 1), x = oscillation(omega, decay, 1 + h);
      const double u = (x - before) / h;
      const double after = x + h * (u + map.keep * u - map.pull * x) / (1 + map.hold);
      EXPECT_NEAR(after, oscillation(omega, decay, 1 + 2 * h), 1e-12) << omega << " " << decay;
    }
  }
}

TEST(SpringStep, AnswersAConstantForceByItsStaticDeflection) {
  const double h = 0.01, mass = 3, force = 7;
  for (const double omega : {1.0, 30.0, 1e3, 1e6}) {
    for (const double decay : {0.0, 60.0, 1e6}) {
      const SpringStep map = SpringStep::of(omega, decay, h);
      const double deflection = force / (mass * omega * omega);
      const double u = (h * force / mass - map.pull * deflection) / (1 + map.hold);
      EXPECT_NEAR(u, 0, 1e-12 * h * force / mass) << omega << " " << decay;
    }
  }
}

TEST(SpringStep, IsStableWhereAStepCannotFollow) {
  const double h = 0.01;
  for (const double omega : {101.0, 300.0, 1e4, 1e8}) {
    const SpringStep map = SpringStep::of(omega, 0, h);
    double x = 1, u = 0, most = 0;
    for (int i = 0; i < 100; ++i) {
      u = (u + map.keep * u - map.pull * x) / (1 + map.hold);
      x += h * u;
      most = std::max(most, std::abs(x));
    }
    EXPECT_LT(most, 1) << omega;
    EXPECT_LT(std::abs(x), 1e-5) << omega;
  }
}

TEST(ExponentialLessOne, IsThatOfTheLibrary) {
  EXPECT_EQ(exponential_less_one(0), 0);
  EXPECT_EQ(exponential_less_one(-1e300), -1);
  EXPECT_TRUE(std::isnan(exponential_less_one(std::nan(""))));
  for (double x = 1e-20; x < 60; x *= 1.01) {
    const double expected = std::expm1(-x);
    ASSERT_NEAR(exponential_less_one(-x), expected, 1e-15 * std::abs(expected)) << x;
  }
}

}  // namespace
}  // namespace atl::solver
