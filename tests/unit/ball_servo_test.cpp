// A ball joint that turns to an orientation.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/motion.h"
#include "support/random.h"

namespace atl {
namespace {

using std::numbers::pi;

constexpr double moment = 0.4;  // kg m^2

/// A body in space that turns about its middle.
struct Rig {
  World world;
  BodyId base, body;
  JointId joint;

  Rig(JointSolver solver, const BallServo& servo, const Vector3& moments = Vector3::Constant(moment),
      const Vector3& spin = Vector3::Zero())
      : world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}}) {
    base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
    body = world.add_body({.shape = Sphere{0.5},
                           .angular_velocity = spin,
                           .mass = 1,
                           .inertia = moments.asDiagonal().toDenseMatrix(),
                           .filter = {.mask = 0}});
    joint = world.add_joint({.kind = BallJoint{.servo = servo}, .first = base, .second = body});
  }

  /// rad, from the target.
  Vector3 left(const Quaternion& target) const {
    const Eigen::AngleAxisd turn(target.conjugate() * world.pose(body).orientation);
    return turn.angle() <= pi ? Vector3(turn.angle() * turn.axis()) : Vector3((turn.angle() - 2 * pi) * turn.axis());
  }
};

Quaternion about(const Vector3& axis, double angle) { return Quaternion(Eigen::AngleAxisd(angle, axis)); }

class BallServos : public testing::TestWithParam<JointSolver> {};

// x'' + 2 z w x' + w^2 x = 0 from rest.
TEST_P(BallServos, SwingToTheTargetAboutAnyAxis) {
  constexpr double omega = 2 * pi * 0.5, ratio = 0.3, dt = 1.0 / 480;
  const double damped = omega * std::sqrt(1 - ratio * ratio);
  test::Random random(1);
  for (int n = 0; n < 5; ++n) {
    const Vector3 axis = random.vector(1).normalized();
    const double angle = random.real(0.3, 3);
    const Quaternion target = about(axis, angle);
    Rig rig(GetParam(), {.target = target, .stiffness = moment * omega * omega, .damping = 2 * ratio * moment * omega});
    for (int i = 1; i <= 960; ++i) {
      rig.world.step(dt);
      const double time = i * dt;
      const double swings = std::cos(damped * time) + ratio * omega / damped * std::sin(damped * time);
      const double expected = -angle * std::exp(-ratio * omega * time) * swings;
      ASSERT_LT((rig.left(target) - expected * axis).norm(), 0.004 * angle) << "step " << i;
    }
  }
}

// A body with unequal moments tumbles over half a turn from the target and back.
TEST_P(BallServos, GainNoEnergy) {
  constexpr double stiffness = 0.2;
  const Quaternion target = about(Vector3(1, 2, -1).normalized(), 2.5);
  Rig rig(GetParam(), {.target = target, .stiffness = stiffness}, {0.2, 0.3, 0.4}, {1, 2, -1});
  const auto energy = [&] {
    return test::motion_of(rig.world).kinetic + 0.5 * stiffness * rig.left(target).squaredNorm();
  };
  const double before = energy();
  double nearest = pi, farthest = 0;
  for (int i = 0; i < 3000; ++i) {
    rig.world.step(1.0 / 120);
    const double away = rig.left(target).norm();
    nearest = std::min(nearest, away);
    farthest = std::max(farthest, away);
    ASSERT_LT(energy(), 1.01 * before) << "step " << i;
  }
  EXPECT_LT(nearest, 1);
  EXPECT_GT(farthest, 3.1);
}

TEST_P(BallServos, PushWithNoMoreThanTheyHave) {
  constexpr double max = 0.3, dt = 1.0 / 240;
  Rig rig(GetParam(), {.target = about(Vector3::UnitY(), 3), .stiffness = 1000, .damping = 10, .max_torque = max});
  for (int i = 0; i < 120; ++i) rig.world.step(dt);
  EXPECT_NEAR(rig.world.angular_velocity(rig.body).y(), max / moment * 120 * dt, 1e-4);
  EXPECT_LT(Vector3(rig.world.angular_velocity(rig.body)).cwiseProduct(Vector3(1, 0, 1)).norm(), 1e-6);
}

TEST_P(BallServos, TakeTheShorterWay) {
  for (const double angle : {pi - 0.01, pi + 0.01}) {
    Rig rig(GetParam(), {.target = about(Vector3::UnitZ(), angle), .stiffness = 1, .damping = 1});
    for (int i = 0; i < 30; ++i) rig.world.step(1.0 / 60);
    EXPECT_GT(rig.world.angular_velocity(rig.body).z() * (pi - angle), 0) << angle;
  }
}

TEST_P(BallServos, FollowATargetThatTurns) {
  const Vector3 spin(0.3, -0.2, 0.5);
  Rig rig(GetParam(), {.stiffness = 40, .damping = 20}, Vector3::Constant(moment), spin);
  for (int i = 0; i < 120; ++i) {
    const Quaternion target = about(spin.normalized(), spin.norm() * i / 60.0);
    rig.world.set_joint(rig.joint, BallJoint{.servo = BallServo{.target = target,
                                                                .angular_velocity = target.conjugate() * spin,
                                                                .stiffness = 40,
                                                                .damping = 20}});
    rig.world.step(1.0 / 60);
  }
  const Quaternion end = about(spin.normalized(), 2 * spin.norm());
  EXPECT_LT(rig.left(end).norm(), 0.01);
  EXPECT_LT((rig.world.angular_velocity(rig.body) - spin).norm(), 0.02);
}

INSTANTIATE_TEST_SUITE_P(All, BallServos, testing::Values(JointSolver::Iterative, JointSolver::Direct));

TEST(BallServo, IsKeptInSnapshots) {
  const BallServo servo{.target = about(Vector3::UnitX(), 0.5),
                        .angular_velocity = {0.1, 0.2, 0.3},
                        .stiffness = 3,
                        .damping = 2,
                        .max_torque = 7};
  Rig rig(JointSolver::Auto, servo);
  Rig other(JointSolver::Auto, {.stiffness = 1});
  Snapshot snapshot;
  rig.world.save(snapshot);
  other.world.restore(snapshot);
  EXPECT_EQ(other.world.joint(other.joint), rig.world.joint(rig.joint));
  EXPECT_EQ(other.world.state_hash(), rig.world.state_hash());
  EXPECT_THROW(rig.world.set_joint(rig.joint, BallJoint{.servo = BallServo{}}), Error) << "no gain";
}

}  // namespace
}  // namespace atl
