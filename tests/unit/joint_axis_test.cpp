// One number of a joint changed, without the rest of its kind being said again.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace atl {
namespace {

constexpr double dt = 1.0 / 60;

struct Rig {
  World world = World({.gravity = Vector3::Zero()});
  BodyId base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
  BodyId arm = world.add_body({.filter = {.mask = 0}});
};

std::string error_of(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(JointAxes, AMotorsSpeedIsOneNumber) {
  Rig rig;
  const JointId wheel = rig.world.add_joint(
      {.kind = HingeJoint{{.motor = JointMotor{.speed = 1, .max_force = 1e6}}}, .first = rig.base, .second = rig.arm});
  for (const double speed : {1.0, -3.0, 0.5}) {
    rig.world.set_motor_speed(wheel, speed);
    for (int i = 0; i < 30; ++i) rig.world.step(dt);
    EXPECT_NEAR(rig.world.joint_state(wheel).speed[0], speed, 1e-6);
    EXPECT_EQ(*rig.world.joint_axis(wheel).motor->max_force, 1e6);
  }
  EXPECT_NE(error_of([&] { rig.world.set_servo_target(wheel, 1); }).find("has no servo"), std::string::npos);
  EXPECT_NE(error_of([&] { rig.world.set_motor_speed(wheel, 1, 1); }).find("HingeJoint has no axis along coordinate 1"),
            std::string::npos);
}

TEST(JointAxes, AServosTargetIsOneNumber) {
  Rig rig;
  SixDofJoint six;
  for (JointAxis& axis : six.offset) axis.range = {0, 0};
  for (JointAxis& axis : six.turn) axis.range = {0, 0};
  const JointServo servo{.stiffness = 1e5, .damping = 2e4};
  six.offset[2] = {.motor = JointMotor{.max_force = unlimited, .servo = servo}};
  const JointId lift = rig.world.add_joint({.kind = six, .first = rig.base, .second = rig.arm});
  rig.world.set_servo_target(lift, 0.25, 2);
  for (int i = 0; i < 300; ++i) rig.world.step(dt);
  EXPECT_NEAR(rig.world.pose(rig.arm).position.z(), 0.25, 1e-3);

  rig.world.set_joint_axis(lift, {.range = {0, 0.1}}, 2);
  for (int i = 0; i < 300; ++i) rig.world.step(dt);
  EXPECT_NEAR(rig.world.pose(rig.arm).position.z(), 0.1, 1e-3);
  EXPECT_FALSE(rig.world.joint_axis(lift, 2).motor);
}

// Each name leads to the axis that the kind has by it.
TEST(JointAxes, CoordinatesHaveNames) {
  Rig rig;
  const auto add = [&](const JointKind& kind) {
    return rig.world.add_joint({.kind = kind, .first = rig.base, .second = rig.arm});
  };
  const auto armature = [&](JointId joint, std::uint32_t number) {
    return rig.world.joint_axis(joint, number).armature;
  };
  WheelJoint wheel;
  wheel.suspension.armature = 1;
  wheel.steering.armature = 2;
  wheel.spin.armature = 3;
  const JointId at_wheel = add(wheel);
  EXPECT_EQ(armature(at_wheel, WheelCoordinate::Suspension), 1);
  EXPECT_EQ(armature(at_wheel, WheelCoordinate::Steering), 2);
  EXPECT_EQ(armature(at_wheel, WheelCoordinate::Spin), 3);
  SixDofJoint six;
  for (std::size_t i = 0; i < 3; ++i) {
    six.offset[i].armature = static_cast<double>(1 + i);
    six.turn[i].armature = static_cast<double>(4 + i);
  }
  const JointId at_six = add(six);
  EXPECT_EQ(armature(at_six, SixDofCoordinate::OffsetX), 1);
  EXPECT_EQ(armature(at_six, SixDofCoordinate::OffsetZ), 3);
  EXPECT_EQ(armature(at_six, SixDofCoordinate::TurnX), 4);
  EXPECT_EQ(armature(at_six, SixDofCoordinate::TurnZ), 6);
  const JointId at_cross = add(UniversalJoint{{.armature = 1}, {.armature = 2}});
  EXPECT_EQ(armature(at_cross, UniversalCoordinate::First), 1);
  EXPECT_EQ(armature(at_cross, UniversalCoordinate::Second), 2);
  EXPECT_EQ(armature(add(ConeTwistJoint{.twist = {.armature = 2}}), ConeTwistCoordinate::Twist), 2);
}

// It goes from the end where it starts to the other, and stays there: no force is given that has no bound.
TEST(JointAxes, AMotorWithoutABoundKeepsToItsRange) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    for (const double start : {-0.5, 0.0, 0.5}) {
      for (const double speed : {-2.0, 2.0}) {
        for (const bool servo : {false, true}) {
          World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}});
          const BodyId base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
          const Quaternion turn(Eigen::AngleAxisd(start, Vector3::UnitX()));
          const BodyId arm = world.add_body({.orientation = turn, .filter = {.mask = 0}});
          JointAxis axis{.range = {-0.5, 0.5}, .motor = JointMotor{.speed = speed, .max_force = unlimited}};
          if (servo) axis.motor->servo = JointServo{.damping = 1e5};
          const JointId hinge = world.add_joint({.kind = HingeJoint{axis}, .first = base, .second = arm});
          for (int i = 0; i < 60; ++i) ASSERT_EQ(world.step(dt).quarantined, 0) << start << ", " << speed;
          EXPECT_NEAR(world.joint_state(hinge).position[0], speed < 0 ? -0.5 : 0.5, 1e-3) << start << ", " << speed;
          EXPECT_NEAR(world.joint_state(hinge).speed[0], 0, 1e-3) << start << ", " << speed;
        }
      }
    }
  }
}

// A coordinate that starts out of its range comes back at 3 rad/s at most, by each solver, alone and with what touches.
TEST(JointAxes, ARangeIsEnteredAtOneSpeedByEverySolver) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    for (const double end : {-0.6, 0.6}) {
      for (const bool touches : {false, true}) {
        World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}});
        const BodyId base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
        const BodyId arm = world.add_body({});
        if (touches) world.add_body({.shape = Sphere{0.5}, .position = {1.0, 0, 0}});
        const JointRange range = end < 0 ? JointRange{-1, end} : JointRange{end, 1};
        const JointId hinge = world.add_joint({.kind = HingeJoint{{.range = range}}, .first = base, .second = arm});
        double before = 0;
        for (int i = 0; i < 60; ++i) {
          world.step(dt);
          const double now = std::abs(world.joint_state(hinge).position[0]);
          ASSERT_LE(now - before, 3.01 * dt) << "step " << i << ", " << end << ", " << touches;
          before = now;
        }
        EXPECT_NEAR(world.joint_state(hinge).position[0], end, 0.003) << end << ", " << touches;
        EXPECT_NEAR(world.joint_state(hinge).speed[0], 0, 0.02) << end << ", " << touches;
      }
    }
  }
}

// Half a turn is where the coordinate ends, not the turning. Where it fades the servo has little to hold by.
TEST(JointAxes, ASixAxisServoOfDampingAloneTurnsOn) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}});
    const BodyId base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
    const BodyId arm = world.add_body({.filter = {.mask = 0}});
    SixDofJoint six;
    for (JointAxis& axis : six.offset) axis.range = {0, 0};
    for (JointAxis& axis : six.turn) axis.range = {0, 0};
    six.turn[0] = {.motor = JointMotor{.speed = 2, .max_force = 1e3, .servo = JointServo{.damping = 1e3}}};
    world.add_joint({.kind = six, .first = base, .second = arm});
    for (int i = 0; i < 600; ++i) {
      world.step(dt);
      // A sixth of a second is how long the damper takes to bring the box to its speed, but for 1/e.
      if (i > 120) {
        ASSERT_NEAR(world.angular_velocity(arm).x(), 2, 0.25) << "step " << i;
      }
    }
  }
}

TEST(JointAxes, ARopeLetsPassWhatComesToItsAnchor) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}});
    const BodyId base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
    const BodyId ball =
        world.add_body({.shape = Sphere{0.1}, .position = {0.5, 0, 0}, .velocity = {-1, 0, 0}, .filter = {.mask = 0}});
    world.add_joint({.kind = DistanceJoint{{.range = {0, 1}}}, .first = base, .second = ball});
    for (int i = 0; i < 60; ++i) world.step(dt);
    EXPECT_NEAR(world.pose(ball).position.x(), -0.5, 1e-3);
    EXPECT_NEAR(world.velocity(ball).x(), -1, 1e-6);
  }
}

TEST(JointAxes, OfEachKindAreThoseThatItsStateTellsOf) {
  Rig rig;
  const std::vector<std::pair<JointKind, std::vector<std::size_t>>> kinds = {
      {BallJoint{}, {}},  {HingeJoint{}, {0}},        {SliderJoint{}, {0}},
      {FixedJoint{}, {}}, {UniversalJoint{}, {0, 1}}, {ConeTwistJoint{}, {1}},
      {GearJoint{}, {}},  {WheelJoint{}, {0, 1, 2}},  {SixDofJoint{}, {0, 1, 2, 3, 4, 5}}};
  for (const auto& [kind, axes] : kinds) {
    const JointId joint = rig.world.add_joint({.kind = kind, .first = rig.base, .second = rig.arm});
    for (std::size_t i = 0; i < 7; ++i) {
      const bool there = std::find(axes.begin(), axes.end(), i) != axes.end();
      EXPECT_EQ(error_of([&] { rig.world.joint_axis(joint, i); }).empty(), there) << kind.index() << ", " << i;
      if (!there) continue;
      const JointAxis axis{.range = {-0.25, 0.125}, .spring = JointSpring{}};
      rig.world.set_joint_axis(joint, axis, i);
      EXPECT_EQ(rig.world.joint_axis(joint, i).range.upper, 0.125);
    }
    rig.world.remove_joint(joint);
  }
}

TEST(JointAxes, AMotorSaysHowHardItMayPush) {
  Rig rig;
  const auto add = [&] {
    rig.world.add_joint({.kind = HingeJoint{{.motor = JointMotor{.speed = 1}}}, .first = rig.base, .second = rig.arm});
  };
  EXPECT_EQ(error_of(add),
            "JointDef.kind.angle.motor.max_force is not given; expected the most (N or N m) that it may push, or "
            "unlimited");
}

}  // namespace
}  // namespace atl
