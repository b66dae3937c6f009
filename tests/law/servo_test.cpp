// Servos and springs of joints by each way to solve them: what they bear, at rest and at the limits of their force.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

const CollisionFilter nothing = {.mask = 0};

HingeJoint servo_hinge(double stiffness, double damping, double limit, double range = 0) {
  HingeJoint hinge{
      {.motor = JointMotor{.max_force = limit, .servo = JointServo{.stiffness = stiffness, .damping = damping}}}};
  if (range > 0) hinge.angle.range = {-range, range};
  return hinge;
}

class ServoLaw : public testing::TestWithParam<JointSolver> {
 protected:
  World world_with(int substeps, const Vector3& gravity = Vector3::Zero()) const {
    return World({.gravity = gravity, .settings = {.substeps = substeps, .joint_solver = GetParam()}});
  }
};

// A load's balance is load over stiffness, whoever makes the load, and what rests is told to be at rest.
TEST_P(ServoLaw, BearsALoadAtItsBalanceAndTellsThatItRests) {
  constexpr double stiffness = 1000, torque = -5;
  for (const int substeps : {1, 4, 16}) {
    for (const bool by_law : {false, true}) {
      World world = world_with(substeps);
      const BodyId base = world.add_body({.type = BodyType::Static, .shape = Sphere{0.05}, .filter = nothing});
      const BodyId link =
          world.add_body({.shape = Box{{0.2, 0.03, 0.03}}, .position = {0.2, 0, 0}, .mass = 2.0, .filter = nothing});
      const JointId hinge =
          world.add_joint(joint_at(world, servo_hinge(stiffness, 20, unlimited), base, link, {0, 0, 0}, {0, 0, 1}));
      for (int i = 0; i < 600; ++i) {
        if (by_law) {
          world.step(dt, [&](Forces& forces) { forces.add(link, Vector3::Zero(), {0, 0, torque}); });
        } else {
          world.apply_force(link, Vector3::Zero(), {0, 0, torque});
          world.step(dt);
        }
      }
      const JointState state = world.joint_state(hinge);
      EXPECT_NEAR(state.position[0], torque / stiffness, 1e-5) << substeps << (by_law ? " by a law" : "");
      EXPECT_NEAR(state.speed[0], 0, 1e-5) << substeps << (by_law ? " by a law" : "");
    }
  }
}

// A weight off the axis rests at the balance of its spring. Swept joints don't come to rest so: a row takes its bodies
// for free, and turns this one 90 times as easily as its point lets it turn.
TEST_P(ServoLaw, AWeightOffTheAxisHangsWhereItsSpringBearsIt) {
  const bool swept = GetParam() == JointSolver::Iterative;
  constexpr double arm = 0.3, mass = 5, stiffness = 2000;
  for (const int substeps : {1, 4, 16}) {
    World world = world_with(substeps, {0, 0, -g});
    const BodyId base = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = nothing});
    const BodyId rod =
        world.add_body({.shape = Sphere{0.05}, .position = {arm, 0, 0}, .mass = mass, .filter = nothing});
    const JointId hinge =
        world.add_joint(joint_at(world, HingeJoint{{.spring = JointSpring{.stiffness = stiffness, .damping = 60}}},
                                 base, rod, {0, 0, 0}, {0, -1, 0}));
    run(world, 600);
    const double angle = world.joint_state(hinge).position[0];
    if (swept && substeps < 16) continue;
    EXPECT_NEAR(stiffness * angle, -mass * g * arm * std::cos(angle), 2e-3 * mass * g * arm) << substeps;
    EXPECT_NEAR(world.joint_state(hinge).speed[0], 0, swept ? 1e-3 : 1e-5) << substeps;
  }
}

// A damper turns at torque over damping, wherever the centre of mass is and whatever makes the torque; and it is told
// so.
TEST_P(ServoLaw, ADamperTurnsAtTorqueOverDamping) {
  constexpr double damping = 200, torque = 20, arm = 0.3, mass = 5;
  for (const int substeps : {1, 4, 16}) {
    for (const bool at_centre : {false, true}) {
      World world = world_with(substeps);
      const BodyId base = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = nothing});
      const BodyId rod = world.add_body({.shape = Sphere{0.05},
                                         .position = {arm, 0, 0},
                                         .mass = mass,
                                         .inertia = Matrix3(1.3 * Matrix3::Identity()),
                                         .filter = nothing});
      const JointId hinge =
          world.add_joint(joint_at(world, HingeJoint{{.spring = JointSpring{.stiffness = 0, .damping = damping}}}, base,
                                   rod, {0, 0, 0}, {0, 0, 1}));
      double at_half = 0;
      for (int i = 0; i < 120; ++i) {
        if (i == 60) at_half = world.joint_state(hinge).position[0];
        const Vector3 outward = world.pose(rod).orientation * Vector3::UnitX();
        const Vector3 force = torque / arm * Vector3::UnitZ().cross(outward);
        world.apply_force(rod, at_centre ? force : Vector3(Vector3::Zero()),
                          at_centre ? Vector3(Vector3::Zero()) : Vector3(0, 0, torque));
        world.step(dt);
      }
      const JointState state = world.joint_state(hinge);
      EXPECT_NEAR(state.position[0] - at_half, torque / damping, 0.01 * torque / damping) << substeps << at_centre;
      EXPECT_NEAR(state.speed[0], torque / damping, 0.02 * torque / damping) << substeps << at_centre;
    }
  }
}

// kg m^2/s about the z axis.
double momentum_about_z(const World& world, const std::vector<BodyId>& ids) {
  double sum = 0;
  for (const BodyId id : ids) {
    const Matrix3 turn = world.pose(id).orientation.toRotationMatrix();
    const Matrix3 inertia = turn * body_mass(world.definition(id)).inertia * turn.transpose();
    sum += world.mass(id) * world.centre_of_mass(id).cross(world.velocity(id)).z() +
           (inertia * world.angular_velocity(id)).z();
  }
  return sum;
}

// Four links on a pan hinge that needs more than its limit to follow its target. Nothing else changes the momentum
// about its axis.
TEST_P(ServoLaw, AServoGivesNoMoreThanItsLimit) {
  for (const double limit : {50.0, 150.0}) {
    World world = world_with(4);
    const BodyId base = world.add_body({.type = BodyType::Static, .shape = Sphere{0.05}, .filter = nothing});
    std::vector<BodyId> links = {
        world.add_body({.shape = Box{{0.06, 0.06, 0.07}}, .position = {0, 0, 0.23}, .mass = 3.0, .filter = nothing})};
    const HingeJoint hinge = servo_hinge(2e4, 400, limit, 2.9);
    const JointId pan = world.add_joint(joint_at(world, hinge, base, links[0], {0, 0, 0.15}, {0, 0, 1}));
    for (int i = 0; i < 4; ++i) {
      const BodyId link = world.add_body(
          {.shape = Box{{0.1, 0.03, 0.03}}, .position = {0.1 + 0.2 * i, 0, 0.3}, .mass = 1.2, .filter = nothing});
      const Vector3 axis = i % 2 != 0 ? Vector3::UnitX() : Vector3::UnitY();
      world.add_joint(joint_at(world, hinge, links.back(), link, {0.2 * i, 0, 0.3}, axis));
      links.push_back(link);
    }
    double before = 0, max = 0;
    for (int i = 1; i <= 360; ++i) {
      const double phase = 2.7 / 1.2 * i * dt;
      world.set_servo_target(pan, 1.2 * std::sin(phase));
      world.set_motor_speed(pan, 2.7 * std::cos(phase));
      world.step(dt);
      const double now = momentum_about_z(world, links);
      max = std::max(max, std::abs(now - before) / dt);
      before = now;
    }
    EXPECT_LT(max, 1.02 * limit);
    EXPECT_GT(max, 0.3 * limit);
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, ServoLaw,
                         testing::Values(JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative),
                         [](const auto& of) {
                           return std::string(of.param == JointSolver::Auto     ? "Auto"
                                              : of.param == JointSolver::Direct ? "Direct"
                                                                                : "Iterative");
                         });

}  // namespace
}  // namespace atl::test
