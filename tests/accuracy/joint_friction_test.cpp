// Friction in joints: a wheel that turns about its centre comes to a stop, at the time that the torque needs.

#include <gtest/gtest.h>

#include <cmath>

#include "support/joined_run.h"

namespace atl::test::joint_friction_test {
namespace {

constexpr double torque = 2;  // N m

class JointFrictionTest : public testing::TestWithParam<JointSolver> {
 protected:
  /// rad/s about `axis`, a while after a cube of 1 kg m^2 that is joined at its centre has turned at `speed`; its x
  /// axis is `swing` about z from the joint's.
  double speed_after(double seconds, const JointKind& kind, double swing, const Vector3& axis, double speed) const {
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = GetParam()}});
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    BodyDef def = box(Vector3::Zero(), Vector3::Constant(0.5));
    def.mass = 6;
    def.orientation = Quaternion(Eigen::AngleAxisd(swing, Vector3::UnitZ()));
    def.angular_velocity = speed * axis;
    const BodyId cube = world.add_body(def);
    world.add_joint({.kind = kind, .first = post, .second = cube});
    for (int step = 0; step < std::lround(seconds / dt); ++step) world.step(dt);
    return world.angular_velocity(cube).dot(axis);
  }

  void expect_stop(const JointKind& kind, double swing, const Vector3& axis) const {
    constexpr double speed = 0.4;  // so that it stops at 0.2 s, having turned by 0.04
    EXPECT_NEAR(speed_after(0.1, kind, swing, axis, speed), speed / 2, 5e-3 * speed);
    EXPECT_NEAR(speed_after(0.3, kind, swing, axis, speed), 0, 1e-6);
  }
};

TEST_P(JointFrictionTest, OfABallIsAboutAllAxes) {
  for (int axis = 0; axis < 3; ++axis) expect_stop(BallJoint{.friction = torque}, 0, Vector3::Unit(axis));
}

TEST_P(JointFrictionTest, OfAConeIsWithItsSwingAndAcross) {
  const ConeTwistJoint cone = {.swing_friction = torque};
  constexpr double swing = 0.5;
  expect_stop(cone, swing, Vector3::UnitZ());
  const Vector3 across = Eigen::AngleAxisd(swing, Vector3::UnitZ()) * Vector3::UnitY();
  expect_stop(cone, swing, across);
  expect_stop(cone, 0, Vector3::UnitY());
  // Turning with the axis is not theirs.
  const Vector3 twist = Eigen::AngleAxisd(swing, Vector3::UnitZ()) * Vector3::UnitX();
  EXPECT_NEAR(speed_after(0.3, cone, swing, twist, 0.4), 0.4, 1e-5);
}

// Hit through its middle, 1 m below the joint, by what makes 1 rad/s of its 7 kg m^2.
TEST_P(JointFrictionTest, TakesUpNoMoreOfABlowThanItsTorque) {
  const JointKind kinds[] = {BallJoint{.friction = torque}, HingeJoint{{.friction = torque}},
                             HingeJoint{{.motor = JointMotor{.max_force = torque}}}};
  for (const JointKind& kind : kinds) {
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = GetParam()}});
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    BodyDef def = box({0, 0, -1});
    def.mass = 6;
    const BodyId cube = world.add_body(def);
    world.add_joint(joint_at(world, kind, post, cube, Vector3::Zero(), Vector3::UnitY()));
    world.apply_impulse(cube, {7, 0, 0}, world.centre_of_mass(cube));
    world.step(dt);
    EXPECT_NEAR(world.angular_velocity(cube).norm(), 1 - torque * dt / 7, 2e-3) << kind.index();
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, JointFrictionTest, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

}  // namespace
}  // namespace atl::test::joint_friction_test
