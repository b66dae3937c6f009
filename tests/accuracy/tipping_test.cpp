// A block on a slope that friction keeps from sliding tips over its lower edge once gravity points past that edge:
// for half width w and half height h, where tan a > w / h.

#include <gtest/gtest.h>

#include <cmath>

#include "support/incline.h"

namespace atl::test::tipping_test {
namespace {

const Vector3 half_extents(0.5, 0.5, 1.5);
const double tipping_slope = half_extents.x() / half_extents.z();
constexpr double friction = 1;

double tilt_after(double slope, Tilt tilt, double seconds) {
  Incline incline = make_incline(std::atan(slope), friction, tilt, half_extents);
  const Quaternion start = incline.world.pose(incline.block).orientation;
  incline.slide(seconds);
  return incline.world.pose(incline.block).orientation.angularDistance(start);
}

class TippingTest : public testing::TestWithParam<Tilt> {};

TEST_P(TippingTest, TallBlockStandsWhileGravityPointsIntoItsBase) {
  // The lower edge carries all of the weight at most, and a contact gives way by less than 1 mm a metre of edge.
  EXPECT_LT(tilt_after(0.9 * tipping_slope, GetParam(), 5), 2e-3);
}

TEST_P(TippingTest, TallBlockTipsBeyond) {
  // About the edge the angle grows as a / k^2 (cosh k t - 1) at first, where a = 0.138 rad/s^2 is the acceleration at
  // the start and k^2 = m g |arm| / I = (2.16 / s)^2: it passes 0.5 rad after 1.7 s.
  EXPECT_GT(tilt_after(1.1 * tipping_slope, GetParam(), 3), 0.5);
}

INSTANTIATE_TEST_SUITE_P(Tilts, TippingTest, testing::Values(Tilt::Gravity, Tilt::Ground), tilt_name);

}  // namespace
}  // namespace atl::test::tipping_test
