// Sleeping is on request. What rests falls asleep as a whole island, does not move a bit while it sleeps, and wakes
// when anything touches it.

#include <gtest/gtest.h>

#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

constexpr int height = 3;

struct SleepingStack {
  World world{WorldDef{.settings = {.sleeping = true}}};
  BodyId base = world.add_body(static_box({0, 0, -0.5}, {5, 5, 0.5}));
  std::vector<BodyId> stack = add_stack(world, height);

  SleepingStack() { run(world, 240); }
  bool all_asleep() const {
    for (BodyId id : stack) {
      if (!world.is_asleep(id)) return false;
    }
    return true;
  }
  bool all_awake() const {
    for (BodyId id : stack) {
      if (world.is_asleep(id)) return false;
    }
    return true;
  }
};

TEST(Sleep, SettledStackFallsAsleep) {
  SleepingStack sleeping;
  EXPECT_TRUE(sleeping.all_asleep());
  const StepReport report = sleeping.world.step(dt);
  EXPECT_EQ(report.counts.asleep, height);
  EXPECT_EQ(report.counts.islands, 0);
  EXPECT_EQ(report.counts.fcl_calls, 0);
}

TEST(Sleep, NothingSleepsUnlessAsked) {
  World world;
  world.add_body(ground());
  const std::vector<BodyId> stack = add_stack(world, height);
  EXPECT_EQ(run(world, 300).counts.asleep, 0);
  EXPECT_FALSE(world.is_asleep(stack[0]));
}

TEST(Sleep, NeedsTheTimeThatWasSet) {
  World world({.settings = {.sleeping = true, .time_to_sleep = 2}});
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  run(world, 115);
  EXPECT_FALSE(world.is_asleep(crate));
  run(world, 60);
  EXPECT_TRUE(world.is_asleep(crate));
}

TEST(Sleep, SleepersDoNotMoveABit) {
  SleepingStack sleeping;
  const Eigen::Matrix3Xd positions = sleeping.world.positions();
  const Eigen::Matrix4Xd orientations = sleeping.world.orientations();
  run(sleeping.world, 120);
  EXPECT_EQ(positions, sleeping.world.positions());
  EXPECT_EQ(orientations, sleeping.world.orientations());
  EXPECT_EQ(sleeping.world.velocity(sleeping.stack[0]), Vector3(0, 0, 0));
}

TEST(Sleep, MovingBodyDoesNotSleep) {
  World world({.gravity = Vector3::Zero(), .settings = {.sleeping = true}});
  BodyDef def = sphere({0, 0, 0});
  def.velocity = {0.2, 0, 0};
  const BodyId id = world.add_body(def);
  run(world, 300);
  EXPECT_FALSE(world.is_asleep(id));
}

TEST(Sleep, BodyThatLandsOnTheStackWakesIt) {
  SleepingStack sleeping;
  sleeping.world.add_body(box({0, 0, height + 1.5}));
  run(sleeping.world, 10);
  EXPECT_TRUE(sleeping.all_asleep()) << "before it lands";
  run(sleeping.world, 30);
  EXPECT_TRUE(sleeping.all_awake());
}

TEST(Sleep, ImpulseWakesTheWholeIsland) {
  SleepingStack sleeping;
  const BodyId top = sleeping.stack.back();
  sleeping.world.apply_impulse(top, {sleeping.world.mass(top) * 0.5, 0, 0}, sleeping.world.pose(top).position);
  EXPECT_FALSE(sleeping.world.is_asleep(top));
  sleeping.world.step(dt);
  EXPECT_TRUE(sleeping.all_awake());
  EXPECT_GT(sleeping.world.velocity(top).x(), 0.1);
}

TEST(Sleep, VelocityPoseForceAndWakeWakeToo) {
  for (int how = 0; how < 4; ++how) {
    SleepingStack sleeping;
    const BodyId top = sleeping.stack.back();
    Pose pose = sleeping.world.pose(top);
    pose.position.z() += 0.5;
    if (how == 0) sleeping.world.set_velocity(top, {0, 0, 1}, {0, 0, 0});
    if (how == 1) sleeping.world.set_pose(top, pose);
    if (how == 2) sleeping.world.apply_force(top, {1, 0, 0});
    if (how == 3) sleeping.world.wake(top);
    sleeping.world.step(dt);
    EXPECT_FALSE(sleeping.world.is_asleep(top)) << how;
  }
}

TEST(Sleep, RemovingTheSupportWakesWhatStoodOnIt) {
  SleepingStack sleeping;
  const BodyId top = sleeping.stack.back();
  sleeping.world.remove_body(sleeping.stack.front());
  run(sleeping.world, 60);
  EXPECT_NEAR(sleeping.world.pose(top).position.z(), height - 1.5, 5e-3) << "it falls by the box's height";
}

TEST(Sleep, RemovingOrMovingTheGroundWakesTheStack) {
  for (const bool remove : {true, false}) {
    SleepingStack sleeping;
    if (remove) {
      sleeping.world.remove_body(sleeping.base);
    } else {
      sleeping.world.set_pose(sleeping.base, {.position = {0, 0, -10}});
    }
    run(sleeping.world, 30);
    EXPECT_LT(sleeping.world.pose(sleeping.stack[0]).position.z(), 0) << remove;
  }
}

TEST(Sleep, WokenStackFallsAsleepAgain) {
  SleepingStack sleeping;
  sleeping.world.wake(sleeping.stack[1]);
  sleeping.world.step(dt);
  EXPECT_TRUE(sleeping.all_awake());
  run(sleeping.world, 120);
  EXPECT_TRUE(sleeping.all_asleep());
}

}  // namespace
}  // namespace atl::test
