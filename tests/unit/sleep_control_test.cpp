// Who sleeps, by definitions and calls, what is told of it, and limits of speed.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

World sleeping_world() {
  Settings settings;
  settings.sleeping = true;
  return World({.settings = settings});
}

BodyDef asleep(BodyDef def) {
  def.awake = false;
  return def;
}

std::vector<SleepEvent> events_of(const World& world) {
  const std::span<const SleepEvent> events = world.sleep_events();
  return {events.begin(), events.end()};
}

TEST(SleepControl, OneThatIsAddedAsleepStaysUntilItIsTouched) {
  World world = sleeping_world();
  const BodyId hangs = world.add_body(asleep(box({0, 0, 3})));
  const BodyId woken = world.add_body(asleep(box({5, 0, 3})));
  EXPECT_FALSE(world.definition(hangs).awake);
  run(world, 60);
  EXPECT_TRUE(world.is_asleep(hangs));
  EXPECT_EQ(world.centre_of_mass(hangs), Vector3(0, 0, 3));
  EXPECT_TRUE(world.sleep_events().empty());
  world.wake(woken);
  world.add_body(sphere({0, 0, 4.2}));
  run(world, 30);
  EXPECT_FALSE(world.is_asleep(hangs));
  EXPECT_LT(world.centre_of_mass(hangs).z(), 3);
  EXPECT_NEAR(world.centre_of_mass(woken).z(), 3 - 0.5 * g * 0.25, 1e-6);
}

TEST(SleepControl, OneThatMayNotSleepKeepsItsIslandAwake) {
  World world = sleeping_world();
  world.add_body(ground());
  BodyDef wakeful = box({0, 0, 0.5});
  wakeful.may_sleep = false;
  const BodyId lower = world.add_body(wakeful);
  const BodyId upper = world.add_body(box({0, 0, 1.5}));
  const BodyId alone = world.add_body(box({5, 0, 0.5}));
  run(world, 180);
  EXPECT_FALSE(world.is_asleep(lower));
  EXPECT_FALSE(world.is_asleep(upper));
  EXPECT_TRUE(world.is_asleep(alone));
  world.sleep(upper);
  EXPECT_FALSE(world.is_asleep(upper));
  expect_error([&] { world.sleep(lower); }, {"World::sleep: BodyDef::may_sleep is false"});
  // Once it may, all sleep.
  BodyDef def = world.definition(lower);
  def.may_sleep = true;
  world.set_definition(lower, def);
  run(world, 180);
  EXPECT_TRUE(world.is_asleep(lower));
  EXPECT_TRUE(world.is_asleep(upper));
}

TEST(SleepControl, EventsTellWhoFellAsleepAndWhoWoke) {
  World world = sleeping_world();
  world.add_body(ground());
  const BodyId low = world.add_body(box({0, 0, 0.5}));
  const BodyId high = world.add_body(box({0, 0, 1.5}));
  const BodyId other = world.add_body(asleep(box({9, 0, 0.5})));
  int fell = 0;
  for (int step = 0; step < 180; ++step) {
    world.step(dt);
    for (const SleepEvent& event : world.sleep_events()) {
      EXPECT_TRUE(event.asleep);
      EXPECT_TRUE(world.is_asleep(event.body));
      EXPECT_TRUE(event.body == low || event.body == high);
      ++fell;
    }
  }
  EXPECT_EQ(fell, 2);
  // Woken by a call, with what sleeps with it; a world that is restored in between tells the same.
  world.wake(low);
  world.remove_body(other);
  World restored = sleeping_world();
  Snapshot saved;
  world.save(saved);
  restored.restore(saved);
  for (World* each : {&world, &restored}) {
    each->step(dt);
    const std::vector<SleepEvent> events = events_of(*each);
    ASSERT_EQ(events.size(), 2u);
    EXPECT_EQ(events[0].body, low);
    EXPECT_EQ(events[1].body, high);
    EXPECT_FALSE(events[0].asleep || events[1].asleep);
    each->step(dt);
    EXPECT_TRUE(each->sleep_events().empty());
  }
}

// A rope over two pulleys whose parts have no rows of their own holds two weights; so does one over two sliders.
TEST(SleepControl, BodiesThatATendonJoinsSleepTogether) {
  for (const bool hangs : {true, false}) {
    World world = sleeping_world();
    const BodyId ceiling = world.add_body(static_box({0, 0, 3.5}, {3, 0.5, 0.5}));
    std::vector<BodyId> weights;
    std::vector<TendonTerm> terms;
    for (const double side : {-1.0, 1.0}) {
      weights.push_back(world.add_body(sphere({side, 0, 0}, 0.1)));
      JointDef part = {.first = ceiling, .second = weights.back()};
      part.frame_first.position = {side, 0, hangs ? -0.5 : -3.5};
      part.kind = hangs ? JointKind(DistanceJoint{{.range = {0, unlimited}}}) : JointKind(SliderJoint{});
      terms.push_back({.joint = world.add_joint(part)});
    }
    world.add_joint({.kind = TendonJoint{.terms = terms, .length = {.range = {-unlimited, hangs ? 6.0 : 0.0}}}});
    run(world, 2);
    world.sleep(weights[0]);
    EXPECT_TRUE(world.is_asleep(weights[0]));
    EXPECT_TRUE(world.is_asleep(weights[1]));
    world.wake(weights[1]);
    EXPECT_FALSE(world.is_asleep(weights[0]));
  }
}

TEST(SleepControl, DefinitionsThatContradictThemselvesAreRefused) {
  World world = sleeping_world();
  BodyDef def = asleep(box({0, 0, 1}));
  def.velocity = {1, 0, 0};
  expect_error([&] { world.add_body(def); }, {"BodyDef.velocity is (1, 0, 0); expected zero", "not awake"});
  def = asleep(box({0, 0, 1}));
  def.may_sleep = false;
  expect_error([&] { world.add_body(def); }, {"BodyDef.awake is false, and may_sleep is"});
  expect_error([&] { world.add_body(asleep(ground())); }, {"BodyDef.awake is false; expected true of a static"});
  def = box({0, 0, 1});
  def.max_speed = 0;
  expect_error([&] { world.add_body(def); }, {"BodyDef.max_speed is 0; expected a finite number above 0"});
  def.max_speed = {};
  def.max_angular_speed = std::nan("");
  expect_error([&] { world.add_body(def); }, {"BodyDef.max_angular_speed is nan"});
}

TEST(SpeedLimit, HoldsWhateverPushes) {
  World world;
  BodyDef def = box({0, 0, 1000});
  def.mass = 1;
  def.max_speed = 2;
  def.max_angular_speed = 3;
  const BodyId limited = world.add_body(def);
  const BodyId free = world.add_body(box({5, 0, 1000}));
  world.apply_impulse(limited, {300, 0, 0}, {0, 0, 1000});
  world.step(dt);
  EXPECT_NEAR(world.velocity(limited).norm(), 2, 1e-9);
  EXPECT_LT(world.centre_of_mass(limited).x(), 2.001 * dt);
  for (int step = 1; step < 180; ++step) {
    world.apply_force(limited, Vector3::Zero(), {0, 0, 5});
    world.step(dt);
    EXPECT_LE(world.velocity(limited).norm(), 2 + 1e-12);
    EXPECT_LE(world.angular_velocity(limited).norm(), 3 + 1e-12);
  }
  // Weight adds to it within a step: at most g dt, half of that in the mean.
  EXPECT_NEAR(world.velocity(limited).z(), -2, 0.01);
  EXPECT_NEAR(world.angular_velocity(limited).z(), 3, 1e-9);
  EXPECT_GT(world.centre_of_mass(limited).z(), 1000 - (2 + 0.5 * g * dt) * 180 * dt);
  EXPECT_NEAR(world.velocity(free).z(), -g * 180 * dt, 1e-9);
}

TEST(Threads, ChangeBetweenStepsWithoutABit) {
  const auto hash = [](bool changes) {
    World world;
    world.add_body(ground());
    for (int i = 0; i < 40; ++i) world.add_body(box({0.4 * (i % 5), 0.3 * (i % 3), 0.6 + 1.1 * i}));
    for (int step = 0; step < 120; ++step) {
      if (changes && step % 20 == 0) world.set_threads(1 + step / 20 % 3);
      world.step(dt);
    }
    return world.state_hash();
  };
  EXPECT_EQ(hash(true), hash(false));
  World world;
  world.set_threads(3);
  EXPECT_EQ(world.threads(), 3);
  expect_error([&] { world.set_threads(0); }, {"World::set_threads: threads is 0; expected 1 to 1024"});
  EXPECT_EQ(world.threads(), 3);
}

}  // namespace
}  // namespace atl::test
