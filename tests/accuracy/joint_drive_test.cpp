// Servos, armatures and bouncing ends of ranges, against closed forms, however the joint is solved.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "support/bodies.h"
#include "support/joined_run.h"
#include "support/min_turn.h"

namespace atl::test::joint_drive_test {
namespace {

constexpr double mass = 2;  // kg

/// A drive along the x axis: a body on a slider, or a wheel whose hinge turns about that axis.
struct Drive {
  World world;
  BodyId body;
  JointId joint;
  bool turns;

  Drive(JointSolver solver, bool turning, const JointAxis& axis, double gravity = 0)
      : world({.gravity = {turning ? 0 : -gravity, 0, 0}, .settings = {.joint_solver = solver}}), turns(turning) {
    const BodyId post = world.add_body(static_box({0, 0, -5}, Vector3::Constant(0.1)));
    const Matrix3 inertia = mass * Matrix3::Identity();
    body = world.add_body({.shape = Box{{0.1, 0.1, 0.1}}, .mass = mass, .inertia = inertia});
    joint = world.add_joint({.kind = turning ? JointKind(HingeJoint{axis}) : JointKind(SliderJoint{axis}),
                             .first = post,
                             .second = body,
                             .frame_first = {.position = {0, 0, 5}}});
  }
  double position() const { return world.joint_state(joint).position[0]; }
  double speed() const { return turns ? world.angular_velocity(body).x() : world.velocity(body).x(); }
  void set_speed(double speed) {
    const Vector3 along(speed, 0, 0);
    world.set_velocity(body, turns ? Vector3::Zero() : along, turns ? along : Vector3::Zero());
  }

  /// The largest distance from a motion over `time` seconds.
  template <typename Motion>
  double error(const Motion& motion, double time, double step = dt) {
    double worst = 0;
    for (int i = 1; i <= std::lround(time / step); ++i) {
      world.step(step);
      worst = std::max(worst, std::abs(position() - motion(i * step)));
    }
    return worst;
  }
};

class JointDrive : public testing::TestWithParam<std::tuple<JointSolver, bool>> {
 protected:
  JointSolver solver = std::get<0>(GetParam());
  bool turns = std::get<1>(GetParam());
  /// Swept joints follow half a substep behind.
  double allowed(double direct, double swept) const { return solver == JointSolver::Iterative ? swept : direct; }
};

JointAxis with_servo(const JointServo& servo, double max_force, double speed = 0) {
  return {.motor = JointMotor{.speed = speed, .max_force = max_force, .servo = servo}};
}

TEST_P(JointDrive, AServoIsADampedOscillatorAboutItsTarget) {
  constexpr double target = 0.5, stiffness = 200, damping = 4;
  for (const double max : {1e6, unlimited}) {
    Drive drive(solver, turns, with_servo({target, stiffness, damping}, max));
    const double decay = damping / (2 * mass), turn = std::sqrt(stiffness / mass - decay * decay);
    const auto motion = [&](double t) {
      return target * (1 - std::exp(-decay * t) * (std::cos(turn * t) + decay / turn * std::sin(turn * t)));
    };
    EXPECT_LT(drive.error(motion, 3), allowed(2e-5, 0.01)) << max;
  }
}

TEST_P(JointDrive, AServoOfSpeedApproachesIt) {
  constexpr double speed = 2, damping = 4, rate = damping / mass;
  Drive drive(solver, turns, with_servo({.damping = damping}, 1e6, speed));
  const auto motion = [&](double t) { return speed * (t - (1 - std::exp(-rate * t)) / rate); };
  EXPECT_LT(drive.error(motion, 2), allowed(2e-5, 0.005));
  EXPECT_NEAR(drive.speed(), speed * (1 - std::exp(-2 * rate)), allowed(2e-5, 0.005));
}

TEST_P(JointDrive, AServoHasNoMoreForceThanItIsGiven) {
  constexpr double max = 3;
  Drive drive(solver, turns, with_servo({.target = 5, .stiffness = 200, .damping = 40}, max));
  EXPECT_LT(drive.error([](double t) { return 0.5 * max / mass * t * t; }, 1), allowed(1e-5, 0.005));
  run(drive.world, 1200);
  EXPECT_NEAR(drive.position(), 5, 1e-4);
}

TEST_P(JointDrive, AServoOfAnyGainsIsStable) {
  for (const double stiffness : {1e4, 1e8, 1e12}) {
    for (const double damping : {0.0, 1e3, 1e9}) {
      Drive drive(solver, turns, with_servo({0.3, stiffness, damping}, unlimited));
      double max = 0;
      for (int i = 0; i < 300; ++i) {
        drive.world.step(dt);
        max = std::max(max, std::abs(drive.position() - 0.3));
      }
      EXPECT_LT(max, 0.301) << stiffness << ", " << damping;
      if (damping == 0) {
        EXPECT_LT(std::abs(drive.position() - 0.3), stiffness < 1e5 ? 0.301 : 1e-3) << stiffness;
      }
    }
  }
}

TEST_P(JointDrive, AServoUnderALoadIsOffByItsStaticDeflection) {
  if (turns) return;
  Drive drive(solver, turns, with_servo({0.5, 2000, 100}, 1e4), g);
  run(drive.world, 600);
  EXPECT_NEAR(drive.position(), 0.5 - mass * g / 2000, 1e-6);
}

TEST_P(JointDrive, AServoAndASpringAddUp) {
  JointAxis axis = with_servo({1, 120, 0}, 1e6);
  axis.spring = JointSpring{.rest = 0, .stiffness = 80};
  Drive drive(solver, turns, axis);
  const double omega = std::sqrt(200 / mass), centre = 120.0 / 200;
  // Each follows its own oscillation exactly; both together to second order.
  EXPECT_LT(drive.error([&](double t) { return centre * (1 - std::cos(omega * t)); }, 2), allowed(2e-3, 0.02));
}

TEST_P(JointDrive, AnArmatureIsInertiaWithoutWeight) {
  constexpr double armature = 3;
  if (turns) {
    Drive drive(solver, turns, {.armature = armature});
    for (int i = 0; i < 60; ++i) {
      drive.world.apply_force(drive.body, Vector3::Zero(), {7, 0, 0});
      drive.world.step(dt);
    }
    EXPECT_NEAR(drive.speed(), 7 / (mass + armature), 1e-4);
    return;
  }
  Drive drive(solver, turns, {.armature = armature}, g);
  const double fall = g * mass / (mass + armature);
  EXPECT_LT(drive.error([&](double t) { return -0.5 * fall * t * t; }, 1), allowed(1e-5, 0.01));
  EXPECT_NEAR(drive.speed(), -fall, 1e-4);
}

TEST_P(JointDrive, AnArmatureSwingsOnASpringOfAFrequencyOrAStiffness) {
  constexpr double armature = 3, hertz = 0.5;
  const double omega = 2 * M_PI * hertz;
  for (const bool linear : {false, true}) {
    JointSpring spring{.hertz = hertz, .damping_ratio = 0, .rest = 1};
    if (linear) spring = {.rest = 1, .stiffness = omega * omega * (mass + armature)};
    Drive drive(solver, turns, {.spring = spring, .armature = armature});
    EXPECT_LT(drive.error([&](double t) { return 1 - std::cos(omega * t); }, 10), allowed(2e-4, 0.02)) << linear;
  }
}

TEST_P(JointDrive, AnEndOfTheRangeGivesBackItsPartOfTheSpeed) {
  for (const double restitution : {0.5, 1.0}) {
    Drive drive(solver, turns, {.range = {-1, 1, restitution}});
    drive.set_speed(3);
    int bounces = 0;
    double before = 3;
    for (int i = 0; i < 120; ++i) {
      drive.world.step(dt);
      if (drive.speed() * before < 0) {
        ++bounces;
        EXPECT_NEAR(drive.speed(), -restitution * before, 1e-5);
      }
      before = drive.speed();
      EXPECT_LT(std::abs(drive.position()), 1 + 1e-3);
    }
    EXPECT_GE(bounces, 2);
  }
}

// Dropped on the end of its range it bounces as high as it fell, and with less than all of it comes to rest.
TEST_P(JointDrive, WhatBouncesKeepsItsEnergyOrRests) {
  if (turns) return;
  for (const double restitution : {1.0, 0.7}) {
    Drive drive(solver, turns, {.range = {-1, unlimited, restitution}}, g);
    double energy = g, after = 0;
    for (int i = 0; i < 600; ++i) {
      drive.world.step(dt);
      after = 0.5 * drive.speed() * drive.speed() + g * (drive.position() + 1);
      EXPECT_LT(after, energy * 1.01);
    }
    if (restitution == 1) {
      EXPECT_NEAR(after, energy, 0.01 * energy);
    } else {
      EXPECT_LT(after, 1e-3);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Solvers, JointDrive,
    testing::Combine(testing::Values(JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative), testing::Bool()),
    [](const auto& test) {
      return solver_name(std::get<0>(test.param)) + (std::get<1>(test.param) ? "Hinge" : "Slider");
    });

// In the middle of a chain, an end of a range that bounces leaves the other joints closed and makes no energy.
TEST(JointDrives, ABounceWithinAChainKeepsItTogether) {
  for (const JointSolver solver : {JointSolver::Direct, JointSolver::Iterative}) {
    World world({.settings = {.joint_solver = solver}});
    BodyId last = world.add_body(static_box({0, 0, 0}, Vector3::Constant(0.05)));
    std::vector<BodyId> links;
    const Quaternion axis = min_turn(Vector3::UnitX(), Vector3::UnitY());
    for (int i = 0; i < 3; ++i) {
      const BodyId link = world.add_body(box({0.5 + i, 0, 0}, {0.5, 0.05, 0.05}));
      world.add_joint({.kind = HingeJoint{{.range = {-0.4, 0.4, 0.8}}},
                       .first = last,
                       .second = link,
                       .frame_first = {.position = {i == 0 ? 0.0 : 0.5, 0, 0}, .orientation = axis},
                       .frame_second = {.position = {-0.5, 0, 0}, .orientation = axis}});
      links.push_back(link);
      last = link;
    }
    const double start = 0;  // J: at rest at height 0
    double max = 0, apart = 0;
    for (int i = 0; i < 600; ++i) {
      world.step(dt);
      double energy = 0;
      for (std::size_t k = 0; k < links.size(); ++k) {
        const double m = world.mass(links[k]);
        const Vector3 moments = box_inertia(m, {0.5, 0.05, 0.05});
        const Vector3 spin = world.pose(links[k]).orientation.conjugate() * world.angular_velocity(links[k]);
        energy += 0.5 * m * world.velocity(links[k]).squaredNorm() + 0.5 * spin.dot(moments.cwiseProduct(spin)) +
                  m * g * world.pose(links[k]).position.z();
        const Vector3 left = world.pose(links[k]).position + world.pose(links[k]).orientation * Vector3(-0.5, 0, 0);
        const Vector3 joint = k == 0 ? Vector3(Vector3::Zero())
                                     : Vector3(world.pose(links[k - 1]).position +
                                               world.pose(links[k - 1]).orientation * Vector3(0.5, 0, 0));
        apart = std::max(apart, (left - joint).norm());
      }
      max = std::max(max, energy);
    }
    const double scale = world.mass(links[0]) * g;
    EXPECT_LT(max, start + 0.05 * scale) << solver_name(solver);
    EXPECT_LT(apart, solver == JointSolver::Direct ? 1e-5 : 0.02) << solver_name(solver);
  }
}

/// The end of an arm of two links after half a second, m. Motors turn it with all their torque, about axes that cross,
/// through rotors that are ten times as heavy.
Vector3 driven_arm(int substeps) {
  World world({.gravity = Vector3::Zero(), .settings = {.substeps = substeps, .joint_solver = JointSolver::Direct}});
  BodyId before = world.add_body(static_box({-0.25, 0, -5}, Vector3::Constant(0.01)));
  const double half = std::sqrt(0.5);
  const Quaternion axes[] = {Quaternion(half, 0, -half, 0), Quaternion(half, 0, 0, half)};
  for (int i = 0; i < 2; ++i) {
    const BodyId link =
        world.add_body({.shape = Box{{0.25, 0.05, 0.05}}, .position = {0.25 + 0.5 * i, 0, 0}, .mass = 0.3});
    const JointMotor motor{.speed = i == 0 ? 1e3 : -1e3, .max_force = 10.0 + 10 * i};
    world.add_joint({.kind = HingeJoint{{.motor = motor, .armature = 3}},
                     .first = before,
                     .second = link,
                     .frame_first = {.position = {0.25, 0, i == 0 ? 5.0 : 0.0}, .orientation = axes[i]},
                     .frame_second = {.position = {-0.25, 0, 0}, .orientation = axes[i]},
                     .collide = false});
    before = link;
  }
  for (int i = 0; i < 30; ++i) world.step(dt);
  return world.pose(before).position;
}

// The energy that a motor gives its rotor isn't made by the joint.
TEST(DrivenRotors, TurnAnArmToSecondOrder) {
  const Vector3 right = driven_arm(256);
  const double coarse = (driven_arm(4) - right).norm(), fine = (driven_arm(16) - right).norm();
  EXPECT_LT(coarse, 1e-5);
  EXPECT_GT(std::log2(coarse / fine) / 2, 1.9);
}

// A servo that is told of a target on the other side pulls there at once, with what it has.
TEST(DrivenServos, GiveNoMoreThanTheyHaveWhereTheirTargetChangesSides) {
  constexpr double max = 10, mass = 3;  // N, kg
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct}) {
    for (const int substeps : {1, 4, 16}) {
      World world({.gravity = Vector3::Zero(), .settings = {.substeps = substeps, .joint_solver = solver}});
      const BodyId base = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = {.mask = 0}});
      const BodyId load = world.add_body({.shape = Sphere{0.1}, .mass = mass, .filter = {.mask = 0}});
      const JointServo servo{.target = -1e4, .stiffness = 5000, .damping = 100};
      const JointId id =
          world.add_joint(joint_at(world, SliderJoint{{.motor = JointMotor{.max_force = max, .servo = servo}}}, base,
                                   load, Vector3::Zero(), Vector3::UnitX()));
      for (int i = 0; i < 40; ++i) {
        if (i % 10 == 0) world.set_servo_target(id, i % 20 == 0 ? -1e4 : 1e4);
        const double before = mass * world.velocity(load).x();
        world.step(dt);
        const double force = (mass * world.velocity(load).x() - before) / dt;
        EXPECT_NEAR(force, i % 20 < 10 ? -max : max, 1e-3 * max) << solver_name(solver) << " x " << substeps;
      }
    }
  }
}

}  // namespace
}  // namespace atl::test::joint_drive_test
