// Energy and momentum of bodies as the audit measures them, against sums made by hand.

#include <atoll/errors.h>
#include <gtest/gtest.h>

#include <numbers>

namespace atl {
namespace {

const Vector3 gravity(0, 0, -10);

// 2 kg at (1, 0, 3), its centre of mass half a metre along the body's x axis, turned by a quarter about z.
MovingBody turned_body() {
  MovingBody body;
  body.mass = {.mass = 2, .centre = {0.5, 0, 0}, .inertia = Vector3(1, 2, 3).asDiagonal()};
  body.state = {.pose = {{1, 0, 3}, Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ()))},
                .velocity = {0, 4, 0},
                .angular_velocity = {5, 0, 0}};
  return body;
}

TEST(MotionReport, AddsUpTranslationAndSpinAboutTheTurnedAxes) {
  const MovingBody body = turned_body();
  const MotionReport report = measure_motion({&body, 1}, gravity);
  // The body's y axis, with a moment of 2, points along -x.
  EXPECT_NEAR(report.kinetic, 0.5 * 2 * 16 + 0.5 * 2 * 25, 1e-12);
  EXPECT_NEAR(report.potential, 2 * 10 * 3, 1e-12);
  EXPECT_LT((report.momentum - Vector3(0, 8, 0)).norm(), 1e-12);
  // The centre of mass is at (1, 0.5, 3).
  const Vector3 orbital = 2 * Vector3(1, 0.5, 3).cross(Vector3(0, 4, 0));
  EXPECT_LT((report.angular_momentum - (orbital + Vector3(10, 0, 0))).norm(), 1e-12);
}

TEST(MotionReport, CountsWeightByTheGravityScale) {
  MovingBody body = turned_body();
  body.gravity_scale = -0.5;
  EXPECT_NEAR(measure_motion({&body, 1}, gravity).potential, -0.5 * 60, 1e-12);
}

TEST(MotionReport, SumsOverBodies) {
  const MovingBody bodies[] = {turned_body(), turned_body()};
  const MotionReport one = measure_motion({bodies, 1}, gravity), two = measure_motion(bodies, gravity);
  EXPECT_DOUBLE_EQ(two.kinetic, 2 * one.kinetic);
  EXPECT_DOUBLE_EQ(two.potential, 2 * one.potential);
  EXPECT_EQ(two.momentum, 2 * one.momentum);
  EXPECT_EQ(two.angular_momentum, 2 * one.angular_momentum);
}

}  // namespace
}  // namespace atl
