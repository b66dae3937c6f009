// Sine and cosine against the C library in long double.

#include <gtest/gtest.h>
#include <solver/trigonometry.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "random.h"

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

// Where one of the two is all but zero, what counts is the part of pi/2 that a double can't hold.
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
TEST(SineCosine, StaysOnTheCircleForHugeAngles) {
  for (double angle : {1e6, 1e9, 1e12, 1e15}) {
    const SineCosine result = sine_cosine(angle);
    EXPECT_NEAR(result.sine * result.sine + result.cosine * result.cosine, 1, 1e-12) << angle;
  }
}

}  // namespace
}  // namespace atl::solver
