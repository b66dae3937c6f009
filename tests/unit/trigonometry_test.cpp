// Sine, cosine, arctangent and exp(x) - 1 against the C library, in long double for angles.

#include <gtest/gtest.h>
#include <solver/integrate/trigonometry.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/random.h"

namespace atl::solver {
namespace {

// In units in the last place of the true value.
long double error_in_ulps(double value, long double truth) {
  const double rounded = std::abs(static_cast<double>(truth));
  const long double ulp = std::nextafter(rounded, std::numeric_limits<double>::infinity()) - rounded;
  return std::abs(value - truth) / ulp;
}

void expect_close(double angle, long double ulps) {
  const SineCosine result = sine_cosine(angle);
  const long double exact = angle;
  ASSERT_LE(error_in_ulps(result.sine, std::sin(exact)), ulps) << "sine of " << angle;
  ASSERT_LE(error_in_ulps(result.cosine, std::cos(exact)), ulps) << "cosine of " << angle;
}

TEST(SineCosine, IsWithinThreeUnitsInTheLastPlace) {
  test::Random random(1);
  for (double reach : {1e-3, 1.0, 10.0, 1e3, 1e5}) {
    for (int i = 0; i < 50'000 && !HasFatalFailure(); ++i) expect_close(random.real(-reach, reach), 3);
  }
}

// Near a zero of sine or cosine the result depends on the part of pi/2 that a double can't hold.
TEST(SineCosine, IsWithinThreeUnitsInTheLastPlaceNearMultiplesOfHalfPi) {
  for (int multiple = -60'000; multiple <= 60'000 && !HasFatalFailure(); multiple += 7) {
    expect_close(multiple * (std::numbers::pi / 2), 3);
  }
}

TEST(SineCosine, IsExactAtZero) {
  EXPECT_EQ(sine_cosine(0).sine, 0);
  EXPECT_EQ(sine_cosine(0).cosine, 1);
  EXPECT_EQ(sine_cosine(1e-300).sine, 1e-300);
}

TEST(SineCosine, IsOddAndEven) {
  test::Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double angle = random.real(0, 100);
    EXPECT_EQ(sine_cosine(-angle).sine, -sine_cosine(angle).sine);
    EXPECT_EQ(sine_cosine(-angle).cosine, sine_cosine(angle).cosine);
  }
}

// Past the range of the accuracy the results still lie on the circle, roughly.
TEST(SineCosine, KnowsNoTurnsOfWhatHasLostThem) {
  for (const double angle : {0x1p50, -0x1p50, 1e50, -1e300}) {
    EXPECT_EQ(sine_cosine(angle).sine, 0) << angle;
    EXPECT_EQ(sine_cosine(angle).cosine, 1) << angle;
  }
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double angle : {infinity, -infinity, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(std::isnan(sine_cosine(angle).sine) && std::isnan(sine_cosine(angle).cosine)) << angle;
  }
}

TEST(SineCosine, StaysOnTheCircleForHugeAngles) {
  for (double angle : {1e6, 1e9, 1e12, 1e15}) {
    const SineCosine result = sine_cosine(angle);
    EXPECT_NEAR(result.sine * result.sine + result.cosine * result.cosine, 1, 1e-12) << angle;
  }
}

void expect_close_arctangent(double y, double x) {
  const long double truth = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
  ASSERT_LE(error_in_ulps(arctangent(y, x), truth), 4) << "arctangent of " << y << ", " << x;
  ASSERT_EQ(std::signbit(arctangent(y, x)), std::signbit(y)) << y << ", " << x;
}

TEST(Arctangent, IsWithinFourUnitsInTheLastPlaceAllRound) {
  test::Random random(3);
  for (int i = 0; i < 200'000 && !HasFatalFailure(); ++i) {
    expect_close_arctangent(random.real(-1, 1), random.real(-1, 1));
  }
}

TEST(Arctangent, IsWithinFourUnitsInTheLastPlaceForAllRatios) {
  test::Random random(4);
  for (int i = 0; i < 200'000 && !HasFatalFailure(); ++i) {
    const double ratio = std::exp2(random.real(-60, 60)), length = std::exp2(random.real(-400, 400));
    for (const double y : {ratio * length, -ratio * length}) {
      expect_close_arctangent(y, length);
      expect_close_arctangent(y, -length);
    }
  }
}

// Tests the points where the reduction changes, and where its remainder cancels.
TEST(Arctangent, IsWithinFourUnitsInTheLastPlaceNearMultiplesOfTwelfthsOfPi) {
  test::Random random(5);
  for (int twelfth = -12; twelfth <= 12; ++twelfth) {
    for (int i = 0; i < 2000 && !HasFatalFailure(); ++i) {
      const double angle = twelfth * std::numbers::pi / 12 + random.real(-1, 1) * std::exp2(random.real(-50, -3));
      const SineCosine direction = sine_cosine(angle);
      expect_close_arctangent(direction.sine, direction.cosine);
    }
  }
}

TEST(Arctangent, KnowsTheAxesAndTheSignsOfZeros) {
  constexpr double pi = std::numbers::pi, inf = std::numeric_limits<double>::infinity();
  constexpr double min = std::numeric_limits<double>::denorm_min(), max = std::numeric_limits<double>::max();
  for (const double y : {0.0, min, 1e-300, 1.0, max, inf}) {
    for (const double x : {0.0, min, 1e-300, 1.0, max, inf}) {
      for (const double signed_y : {y, -y}) {
        for (const double signed_x : {x, -x}) {
          const double angle = arctangent(signed_y, signed_x), expected = std::atan2(signed_y, signed_x);
          EXPECT_DOUBLE_EQ(angle, expected) << signed_y << ", " << signed_x;
          EXPECT_EQ(std::signbit(angle), std::signbit(expected)) << signed_y << ", " << signed_x;
        }
      }
    }
  }
  EXPECT_EQ(arctangent(0, -1), pi);
  EXPECT_EQ(arctangent(-0.0, -1), -pi);
  EXPECT_EQ(arctangent(1, 0), pi / 2);
  EXPECT_EQ(arctangent(-1, 0), -pi / 2);
  EXPECT_EQ(arctangent(1, 1), pi / 4);
  EXPECT_EQ(arctangent(-1, -1), -3 * pi / 4);
  EXPECT_EQ(arctangent(-inf, -inf), -3 * pi / 4);
  EXPECT_EQ(arctangent(1e-300, 1), 1e-300);
}

TEST(Arctangent, IsNotANumberOfOne) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double other : {0.0, -1.0, 1.0, std::numeric_limits<double>::infinity(), nan}) {
    EXPECT_TRUE(std::isnan(arctangent(nan, other))) << other;
    EXPECT_TRUE(std::isnan(arctangent(other, nan))) << other;
  }
}

TEST(Arctangent, UndoesSineAndCosine) {
  test::Random random(6);
  for (int i = 0; i < 10'000; ++i) {
    const double angle = random.real(-std::numbers::pi, std::numbers::pi);
    const SineCosine direction = sine_cosine(angle);
    EXPECT_NEAR(arctangent(direction.sine, direction.cosine), angle, 2e-15);
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
