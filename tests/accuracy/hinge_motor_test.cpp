// A flywheel on a hinge, driven by a motor of limited torque, against a load.

#include <gtest/gtest.h>

#include <cmath>

#include "support/joined_run.h"

namespace atl::test::hinge_motor_test {
namespace {

constexpr double torque = 10;  // N m, of the motor
constexpr double speed = 5;    // rad/s

struct Flywheel {
  World world;
  BodyId wheel = {};
  JointId hinge = {};
  double inertia = 0;  ///< kg m^2

  explicit Flywheel(JointSolver solver) : world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}}) {
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    const Vector3 half_extents(0.1, 0.5, 0.5);
    BodyDef def = box(Vector3::Zero(), half_extents);
    def.mass = 12;
    inertia = box_inertia(*def.mass, half_extents).x();
    wheel = world.add_body(def);
    hinge = world.add_joint({.kind = HingeJoint{{.motor = JointMotor{.speed = speed, .max_force = torque}}},
                             .first = post,
                             .second = wheel});
  }
  /// rad/s, after so many seconds under a load in N m.
  double run(double seconds, double load) {
    for (int step = 0; step < std::lround(seconds / dt); ++step) {
      world.apply_force(wheel, Vector3::Zero(), {-load, 0, 0});
      world.step(dt);
    }
    return world.angular_velocity(wheel).x();
  }
};

class HingeMotorTest : public testing::TestWithParam<JointSolver> {
 protected:
  // Joined bodies that are solved at once get their forces half a substep before and after the joints, and the speed of
  // the substep in between is what motors see: rad/s.
  double half_kick(double load) const {
    return GetParam() == JointSolver::Direct ? load / flywheel_.inertia * substep() / 2 : 0;
  }
  Flywheel flywheel_{GetParam()};
};

TEST_P(HingeMotorTest, ReachesItsSpeedUnderItsTorque) {
  const double time = flywheel_.inertia * speed / torque;
  const double half = flywheel_.run(time / 2, 0);
  const double full = flywheel_.run(time, 0);
  EXPECT_NEAR(half, speed / 2, 1e-5 * speed);
  EXPECT_NEAR(full, speed, 1e-5 * speed);
}

TEST_P(HingeMotorTest, HoldsItsSpeedUnderALoadBelowItsTorque) {
  flywheel_.run(6, 0.8 * torque);
  EXPECT_NEAR(flywheel_.run(1, 0.8 * torque), speed, half_kick(0.8 * torque) + 1e-5 * speed);
  const auto angle = [&] { return flywheel_.world.joint_state(flywheel_.hinge).position[0]; };
  const double before = angle();
  flywheel_.run(2, 0.8 * torque);
  EXPECT_NEAR(angle() - before, 2 * speed, 1e-5 * 2 * speed);
  const double t = flywheel_.world.joint_state(flywheel_.hinge).torque.x();
  EXPECT_NEAR(t, 0.8 * torque, 1e-3 * torque);
}

TEST_P(HingeMotorTest, StallsUnderALoadAboveIt) {
  flywheel_.run(2, 0);
  // It is slowed down, stands still at some time, and is turned back, always by the excess of the load.
  double expected = speed;
  for (int second = 1; second <= 8; ++second) {
    expected -= 0.2 * torque / flywheel_.inertia;
    const double now = flywheel_.run(1, 1.2 * torque);
    EXPECT_NEAR(now, expected, half_kick(1.2 * torque) + 5e-5 * speed) << second;
  }
  EXPECT_LT(expected, 0);
}

INSTANTIATE_TEST_SUITE_P(Solvers, HingeMotorTest, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

// Bodies turn by their spin times time, however far that is in a substep: else gears slip from each other.
TEST(HingeMotor, TurnsAWheelAsFarAsItsSpeedTells) {
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct}) {
    for (const int substeps : {1, 4}) {
      for (const double rate : {7.0, 67.0, 100.0}) {
        World world({.gravity = Vector3::Zero(), .settings = {.substeps = substeps, .joint_solver = solver}});
        const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
        const BodyId wheel = world.add_body({.shape = Sphere{0.1}, .angular_velocity = {rate, 0, 0}});
        const JointMotor motor{.speed = rate, .max_force = 1e9};
        const JointId hinge =
            world.add_joint({.kind = HingeJoint{{.motor = motor}}, .first = post, .second = wheel, .collide = false});
        for (int i = 0; i < 300; ++i) world.step(dt);
        EXPECT_NEAR(world.joint_state(hinge).position[0], 5 * rate, 5e-5 * rate) << solver_name(solver) << substeps;
      }
    }
  }
}

}  // namespace
}  // namespace atl::test::hinge_motor_test
