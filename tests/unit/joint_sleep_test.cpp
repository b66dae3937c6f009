// Joined bodies sleep and wake as a whole.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

// Two balls that hang below each other from a post, and touch nothing.
struct Hanging {
  World world{WorldDef{.settings = {.sleeping = true}}};
  BodyId post;
  BodyId upper = world.add_body(sphere({0, 0, -2}));
  BodyId lower = world.add_body(sphere({0, 0, -4}));
  JointId top;
  JointId middle;

  explicit Hanging(BodyType type = BodyType::Static)
      : post(world.add_body({.type = type, .shape = Box{}, .position = {0, 0, 0}})) {
    top = world.add_joint({.first = post, .second = upper, .frame_second = {{0, 0, 2}, Quaternion::Identity()}});
    middle = world.add_joint({.first = upper, .second = lower, .frame_second = {{0, 0, 2}, Quaternion::Identity()}});
    run(world, 60);
  }
  bool asleep() const { return world.is_asleep(upper) && world.is_asleep(lower); }
  bool awake() const { return !world.is_asleep(upper) && !world.is_asleep(lower); }
};

TEST(JointSleep, WhatHangsTogetherFallsAsleepTogether) {
  Hanging hanging;
  ASSERT_TRUE(hanging.asleep());
  const Eigen::Matrix3Xd positions = hanging.world.positions();
  const Vector3 force = hanging.world.joint_state(hanging.top).force;
  const StepReport report = hanging.world.step(dt);
  EXPECT_EQ(report.counts.asleep, 2);
  EXPECT_EQ(report.counts.joints, 0) << "of awake bodies";
  EXPECT_EQ(report.counts.active_bodies, 0);
  EXPECT_EQ(hanging.world.positions(), positions);
  EXPECT_EQ(hanging.world.joint_state(hanging.top).force, force) << "it still holds";
  EXPECT_NEAR(force.z(), (hanging.world.mass(hanging.upper) + hanging.world.mass(hanging.lower)) * g, 1e-2 * force.z());
}

TEST(JointSleep, NeitherSleepsWhileTheOtherMoves) {
  Hanging hanging;
  hanging.world.set_velocity(hanging.lower, {0.5, 0, 0}, Vector3::Zero());
  for (int i = 0; i < 60; ++i) {
    hanging.world.step(dt);
    ASSERT_TRUE(hanging.awake()) << i;
  }
}

struct Wake {
  const char* what;
  std::function<void(Hanging&)> call;
};

TEST(JointSleep, AnythingDoneToOneWakesAll) {
  const Wake wakes[] = {
      {"wake", [](Hanging& h) { h.world.wake(h.lower); }},
      {"force",
       [](Hanging& h) {
         h.world.apply_force(h.upper, {1, 0, 0});
       }},
      {"velocity", [](Hanging& h) { h.world.set_velocity(h.upper, Vector3::Zero(), Vector3::Zero()); }},
      {"pose", [](Hanging& h) { h.world.set_pose(h.lower, h.world.pose(h.lower)); }},
      {"pose of the post", [](Hanging& h) { h.world.set_pose(h.post, h.world.pose(h.post)); }},
      {"another joint", [](Hanging& h) { h.world.add_joint({.first = h.post, .second = h.lower}); }},
      {"one joint less", [](Hanging& h) { h.world.remove_joint(h.top); }},
      {"a changed joint", [](Hanging& h) { h.world.set_joint(h.top, BallJoint{1}); }},
      {"a joint disabled", [](Hanging& h) { h.world.set_joint_enabled(h.middle, false); }},
      {"no post", [](Hanging& h) { h.world.remove_body(h.post); }},
  };
  for (const Wake& wake : wakes) {
    Hanging hanging;
    ASSERT_TRUE(hanging.asleep()) << wake.what;
    wake.call(hanging);
    EXPECT_TRUE(hanging.awake()) << wake.what;
    const StepReport report = hanging.world.step(dt);
    EXPECT_EQ(report.counts.asleep, 0) << wake.what;
    EXPECT_EQ(report.counts.active_bodies, 2) << wake.what;
  }
}

TEST(JointSleep, AJointThatDoesNothingWakesNobody) {
  Hanging hanging;
  hanging.world.set_joint_enabled(hanging.top, false);
  hanging.world.set_gravity(Vector3::Zero());
  hanging.world.set_velocity(hanging.upper, Vector3::Zero(), Vector3::Zero());
  hanging.world.set_velocity(hanging.lower, Vector3::Zero(), Vector3::Zero());
  run(hanging.world, 60);
  ASSERT_TRUE(hanging.asleep());
  hanging.world.set_pose(hanging.post, {.position = {0, 0, 9}});
  EXPECT_TRUE(hanging.asleep());
  hanging.world.set_joint_enabled(hanging.top, true);
  EXPECT_TRUE(hanging.awake());
}

TEST(JointSleep, AKinematicBodyThatMovesKeepsWhatHangsOnItAwake) {
  Hanging hanging(BodyType::Kinematic);
  ASSERT_TRUE(hanging.asleep()) << "it stands";
  // Slower than what counts as rest.
  hanging.world.set_velocity(hanging.post, {0, 0, 0.01}, Vector3::Zero());
  for (int i = 0; i < 120; ++i) {
    hanging.world.step(dt);
    ASSERT_TRUE(hanging.awake()) << i;
  }
  EXPECT_NEAR(hanging.world.pose(hanging.lower).position.z(), -4 + 0.02, 1e-3);
  hanging.world.set_velocity(hanging.post, Vector3::Zero(), Vector3::Zero());
  run(hanging.world, 60);
  EXPECT_TRUE(hanging.asleep());
}

// However slow a motor runs, what it moves doesn't rest; what it can't move does.
TEST(JointSleep, AMotorKeepsAwakeWhatItMoves) {
  for (const bool strong : {true, false}) {
    World world({.settings = {.sleeping = true}});
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
    const BodyId arm = world.add_body(box({2, 0, 0}));
    const double load = world.mass(arm) * g * 2;
    // The arm points along x, on a hinge along y, and a stop holds it up.
    const Quaternion to_y(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ()));
    const JointAxis angle{.range = {.upper = 0},
                          .motor = JointMotor{.speed = -0.01, .max_force = (strong ? 2 : 0.5) * load}};
    const JointId hinge = world.add_joint({.kind = HingeJoint{angle},
                                           .first = post,
                                           .second = arm,
                                           .frame_first = {{0, 0, 0}, to_y},
                                           .frame_second = {{-2, 0, 0}, to_y}});
    run(world, 180);
    EXPECT_EQ(world.is_asleep(arm), !strong);
    EXPECT_NEAR(world.joint_state(hinge).position[0], strong ? -0.03 : 0, 2e-3);
    world.set_joint(hinge, HingeJoint{{.motor = JointMotor{.speed = -0.01, .max_force = 2 * load}}});
    EXPECT_FALSE(world.is_asleep(arm));
  }
}

// A body of 1 kg on a post, by a joint of this kind along z.
struct Drawn {
  World world;
  BodyId body;
  JointId joint;

  Drawn(const Settings& settings, const JointKind& kind, double weight)
      : world({.gravity = {0, 0, -weight}, .settings = settings}) {
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = {.mask = 0}});
    body = world.add_body({.shape = Sphere{0.5}, .mass = 1.0});
    joint = world.add_joint(joint_at(world, kind, post, body, Vector3::Zero(), Vector3::UnitZ()));
  }
  double position() const { return world.joint_state(joint).position[0]; }
};

// However slowly a servo or a damped spring gets to its balance, what it moves doesn't rest before it is there: within
// 0.5 mm, that is 1 mrad of these balls.
TEST(JointSleep, AServoOrSpringThatCreepsKeepsAwakeWhatItMoves) {
  constexpr double way = 0.04, time_constant = 1;
  const JointMotor servo{.max_force = unlimited,
                         .servo = JointServo{.target = way, .stiffness = 100, .damping = 100 * time_constant}};
  const JointSpring by_force{.stiffness = g / way, .damping = g / way * time_constant};
  const double hertz = std::sqrt(g / way) / (2 * std::numbers::pi);
  const JointSpring by_hertz{.hertz = hertz, .damping_ratio = std::numbers::pi * hertz * time_constant};
  const std::pair<JointKind, double> drawn[] = {{SliderJoint{{.motor = servo}}, way},
                                                {HingeJoint{{.motor = servo}}, way},
                                                {SliderJoint{{.spring = by_force}}, -way},
                                                {SliderJoint{{.spring = by_hertz}}, -way}};
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    for (const int substeps : {1, 4}) {
      for (const auto& [kind, balance] : drawn) {
        SCOPED_TRACE(testing::Message() << static_cast<int>(solver) << ", substeps " << substeps << ", kind "
                                        << kind.index() << " to " << balance);
        Drawn run({.substeps = substeps, .joint_solver = solver, .sleeping = true}, kind, balance < 0 ? g : 0);
        for (int step = 1; step <= 120; ++step) {
          run.world.step(dt);
          ASSERT_FALSE(run.world.is_asleep(run.body)) << step;
          ASSERT_NEAR(run.position(), balance * (1 - std::exp(-step * dt / time_constant)), 0.05 * way) << step;
        }
        test::run(run.world, 240);
        EXPECT_TRUE(run.world.is_asleep(run.body));
        EXPECT_NEAR(run.position(), balance, 2e-3);
      }
    }
  }
}

}  // namespace
}  // namespace atl::test
