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

TEST(Sleep, KinematicBodyThatRunsIntoTheStackWakesIt) {
  SleepingStack sleeping;
  BodyDef def = box({3, 0, 1.5});
  def.type = BodyType::Kinematic;
  const BodyId ram = sleeping.world.add_body(def);
  run(sleeping.world, 60);
  EXPECT_TRUE(sleeping.all_asleep()) << "while it stands still";
  sleeping.world.set_velocity(ram, {-2, 0, 0}, Vector3::Zero());
  run(sleeping.world, 45);
  EXPECT_TRUE(sleeping.all_asleep()) << "it is still half a metre away";
  run(sleeping.world, 30);
  EXPECT_TRUE(sleeping.all_awake());
  EXPECT_LT(sleeping.world.pose(sleeping.stack[1]).position.x(), -0.1) << "it is pushed along";
}

TEST(Sleep, OnlyWhatIsWokenIsWoken) {
  World world({.settings = {.sleeping = true}});
  world.add_body(ground());
  std::vector<std::vector<BodyId>> stacks;
  for (int i = 0; i < 20; ++i) stacks.push_back(add_stack(world, height, {3.0 * i, 0, 0}));
  run(world, 240);
  world.wake(stacks[7][1]);
  const StepReport report = world.step(dt);
  EXPECT_EQ(report.counts.asleep, 19 * height);
  EXPECT_EQ(report.counts.islands, 1);
  EXPECT_EQ(report.counts.contacts, height);
  for (int i = 0; i < 20; ++i) {
    for (const BodyId id : stacks[static_cast<std::size_t>(i)]) EXPECT_EQ(world.is_asleep(id), i != 7);
  }
}

// Sleeping bodies aren't updated, so a world asleep costs nothing, and one island awake costs as much as it does alone.
TEST(Sleep, CostsNothing) {
  World world({.settings = {.sleeping = true}});
  world.add_body(ground());
  std::vector<BodyId> boxes;
  for (int i = 0; i < 400; ++i) boxes.push_back(world.add_body(box({1.1 * (i % 20), 1.1 * (i / 20), 0.5})));
  BodyDef def = box({-5, 0, 0.5});
  def.type = BodyType::Kinematic;
  const BodyId piston = world.add_body(def);
  const StepReport awake = world.step(dt);
  EXPECT_EQ(awake.counts.active_bodies, 400);
  EXPECT_GT(awake.counts.active_contacts, 400) << "neighbours are near each other, too";
  run(world, 120);

  const StepReport asleep = world.step(dt);
  EXPECT_EQ(asleep.counts.asleep, 400);
  EXPECT_GT(asleep.counts.pairs, 400) << "they are remembered";
  EXPECT_EQ(asleep.counts.active_bodies, 0);
  EXPECT_EQ(asleep.counts.active_contacts, 0);
  EXPECT_EQ(asleep.counts.contacts, 0);
  EXPECT_EQ(asleep.counts.points, 0);
  EXPECT_EQ(asleep.counts.islands, 0);
  EXPECT_EQ(asleep.counts.recycled_manifolds + asleep.counts.recomputed_manifolds, 0);

  world.wake(boxes[210]);
  const StepReport one = world.step(dt);
  EXPECT_EQ(one.counts.active_bodies, 1);
  EXPECT_EQ(one.counts.active_contacts, 9) << "the ground, and eight neighbours";
  EXPECT_EQ(one.counts.asleep, 399);

  world.set_velocity(piston, {0, 0, 1}, Vector3::Zero());
  EXPECT_EQ(world.step(dt).counts.active_bodies, 2);
  world.set_velocity(piston, Vector3::Zero(), Vector3::Zero());
  EXPECT_EQ(world.step(dt).counts.active_bodies, 1);
  world.remove_body(boxes[210]);
  EXPECT_EQ(world.step(dt).counts.active_bodies, 0);
}

TEST(Sleep, SleepersStillPressOnWhatTheyRestOn) {
  SleepingStack sleeping;
  double onto_base = 0;
  for (const ContactForce& contact : sleeping.world.contact_forces()) {
    if (contact.a == sleeping.base || contact.b == sleeping.base) onto_base += contact.normal_force;
  }
  double weight = 0;
  for (const BodyId id : sleeping.stack) weight += sleeping.world.mass(id) * g;
  EXPECT_NEAR(onto_base, weight, 1e-2 * weight);

  const std::vector<ContactForce> before(sleeping.world.contact_forces().begin(),
                                         sleeping.world.contact_forces().end());
  sleeping.world.add_body(sphere({20, 0, 50}));
  run(sleeping.world, 20);
  const auto after = sleeping.world.contact_forces();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_EQ(after[i].position, before[i].position);
    EXPECT_EQ(after[i].normal_force, before[i].normal_force);
    EXPECT_EQ(after[i].feature_id, before[i].feature_id);
  }
}

TEST(Sleep, FallingAsleepAndWakingAreNoContactEvents) {
  World world({.settings = {.sleeping = true, .contact_events = true}});
  const BodyId base = world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  const BodyId other = world.add_body(box({5, 0, 0.5}));
  const auto events_of = [&](int steps) {
    std::vector<ContactEvent> events;
    for (int i = 0; i < steps; ++i) {
      world.step(dt);
      for (const ContactEvent& event : world.contact_events()) events.push_back(event);
    }
    return events;
  };
  const std::vector<ContactEvent> settling = events_of(120);
  ASSERT_EQ(settling.size(), 2u);
  EXPECT_TRUE(settling[0].began && settling[1].began);
  ASSERT_TRUE(world.is_asleep(crate));
  EXPECT_TRUE(events_of(10).empty()) << "asleep";
  world.wake(crate);
  EXPECT_TRUE(events_of(10).empty()) << "one awake";
  EXPECT_TRUE(events_of(60).empty()) << "asleep again";

  Settings settings = world.settings();
  settings.contact_events = false;
  world.set_settings(settings);
  world.remove_body(other);
  for (int i = 0; i < 5; ++i) world.step(1.0 / 60);  // not asked for
  settings.contact_events = true;
  world.set_settings(settings);
  const std::vector<ContactEvent> missed = events_of(1);
  ASSERT_EQ(missed.size(), 1u);
  EXPECT_EQ(missed[0].b, other);
  EXPECT_FALSE(missed[0].began);

  world.set_velocity(crate, {0, 0, 5}, Vector3::Zero());
  const std::vector<ContactEvent> lifting = events_of(5);
  ASSERT_EQ(lifting.size(), 1u);
  EXPECT_EQ(lifting[0].a, base);
  EXPECT_EQ(lifting[0].b, crate);
  EXPECT_FALSE(lifting[0].began);
}

TEST(Sleep, IndexOfARemovedSleeperIsFreeForAnyBody) {
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic, BodyType::Dynamic}) {
    SleepingStack sleeping;
    sleeping.world.remove_body(sleeping.stack.back());
    BodyDef def = box({0, 0, 10});
    def.type = type;
    const BodyId again = sleeping.world.add_body(def);
    ASSERT_EQ(again.index, sleeping.stack.back().index);
    const StepReport report = sleeping.world.step(dt);
    EXPECT_EQ(report.counts.active_bodies, height - 1 + (type == BodyType::Dynamic)) << "the others were woken";
    run(sleeping.world, 240);
    EXPECT_EQ(sleeping.world.is_asleep(again), type == BodyType::Dynamic);
    const double expected = type == BodyType::Dynamic ? height - 0.5 : 10;
    EXPECT_NEAR(sleeping.world.pose(again).position.z(), expected, 0.01);
  }
}

}  // namespace
}  // namespace atl::test
