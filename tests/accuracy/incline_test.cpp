// A block on a slope of angle a holds while tan a < mu and slides with g (sin a - mu cos a) beyond.

#include "support/incline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace atl::test::incline_test {
namespace {

constexpr double friction = 0.5;

class InclineTest : public testing::TestWithParam<Tilt> {};

TEST_P(InclineTest, HoldsBelowTheAngleOfFriction) {
  for (const double share : {0.5, 0.8, 0.95}) {
    const double angle = std::atan(share * friction);
    Incline incline = make_incline(angle, friction, GetParam());
    // Friction follows the normal force by at most a substep, in which the block gains g sin a h; what friction can
    // give beyond the load stops it again within 1 / (1 - share) substeps.
    const double slip = g * std::sin(angle) * substep() * substep() / (1 - share);
    EXPECT_LT(std::abs(incline.slide(1)), slip) << share;

    const double settled = incline.travel();
    EXPECT_NEAR(incline.slide(4), settled, 1e-5) << "creeps at " << share;
  }
}

TEST_P(InclineTest, SlidesBeyondItWithTheDifferenceOfSlopeAndFriction) {
  for (const double share : {1.05, 1.5, 2.0}) {
    const double angle = std::atan(share * friction);
    Incline incline = make_incline(angle, friction, GetParam());
    const double acceleration = g * (std::sin(angle) - friction * std::cos(angle));
    incline.slide(0.5);
    const double early = incline.speed();
    incline.slide(1);
    EXPECT_NEAR(incline.speed() - early, acceleration * 1, 0.01 * acceleration) << share;
    EXPECT_NEAR(incline.travel(), 0.5 * acceleration * 1.5 * 1.5, 0.02 * 0.5 * acceleration * 1.5 * 1.5 + 1e-3)
        << share;
  }
}

TEST_P(InclineTest, ContactForceBalancesTheWeight) {
  const double angle = std::atan(0.8 * friction);
  Incline incline = make_incline(angle, friction, GetParam());
  incline.slide(1);
  const Vector3 weight = incline.world.mass(incline.block) * incline.world.gravity();
  const Vector3 support = contact_force(incline.world, incline.plane, incline.block);
  EXPECT_LT((support + weight).norm(), 0.005 * weight.norm());
}

INSTANTIATE_TEST_SUITE_P(Tilts, InclineTest, testing::Values(Tilt::Gravity, Tilt::Ground), tilt_name);

}  // namespace
}  // namespace atl::test::incline_test
