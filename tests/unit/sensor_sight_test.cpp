// Sensors that are asked to see more: static bodies, other sensors, and what passes through within a step.

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "support/bodies.h"

namespace atl::test::sensor_sight_test {
namespace {

World without_gravity() { return World({.gravity = Vector3::Zero()}); }

BodyDef sensor_at(const Vector3& position, const Shape& shape = Sphere{0.3}) {
  return {.type = BodyType::Static, .shape = shape, .position = position, .sensor = true};
}

TEST(SensorSight, ReachesStaticBodiesOnlyWhereAsked) {
  for (const bool asked : {false, true}) {
    World world = without_gravity();
    BodyDef probe = sensor_at({0, 0, 0.2});
    probe.type = BodyType::Kinematic;
    probe.velocity = {0, 0, 1};
    probe.notices_static = asked;
    const BodyId sensor = world.add_body(probe);
    const BodyId floor = world.add_body(ground());
    world.step(dt);
    EXPECT_EQ(world.bodies_in(sensor), asked ? std::vector{floor} : std::vector<BodyId>{});
    run(world, 10);
    EXPECT_TRUE(world.bodies_in(sensor).empty());
  }
}

TEST(SensorSight, ReachesOtherSensorsOnlyWhereAsked) {
  World world = without_gravity();
  BodyDef seeing = sensor_at({0, 0, 0});
  seeing.notices_sensors = true;
  const BodyId a = world.add_body(seeing);
  const BodyId b = world.add_body({.shape = Sphere{0.3}, .position = {0.4, 0, 0}, .sensor = true});
  const BodyId c =
      world.add_body({.shape = Sphere{0.3}, .position = {-0.4, 0, 0}, .filter = {.category = 8}, .sensor = true});
  world.step(dt);
  EXPECT_EQ(world.bodies_in(a), (std::vector{b, c}));
  EXPECT_TRUE(world.bodies_in(b).empty());
  world.set_filter(a, {.mask = 8});
  world.step(dt);
  EXPECT_EQ(world.bodies_in(a), std::vector{c});
}

// Events of all sensors over so many steps.
std::vector<SensorEvent> sensor_events_of(World& world, int steps) {
  std::vector<SensorEvent> passages;
  for (int step = 0; step < steps; ++step) {
    world.step(dt);
    passages.insert(passages.end(), world.sensor_events().begin(), world.sensor_events().end());
  }
  return passages;
}

void expect_passed(const std::vector<SensorEvent>& passages, BodyId sensor, BodyId body) {
  ASSERT_EQ(passages.size(), 2u);
  for (const SensorEvent& event : passages) {
    EXPECT_EQ(event.sensor, sensor);
    EXPECT_EQ(event.body, body);
  }
  EXPECT_TRUE(passages[0].entered);
  EXPECT_FALSE(passages[1].entered);
}

TEST(SensorSight, SeesABulletPassIfContinuous) {
  for (const bool continuous : {false, true}) {
    for (int phase = 0; phase < 10; ++phase) {
      World world = without_gravity();
      BodyDef gate = sensor_at({0, 0, 0}, Box{{0.005, 1, 1}});
      gate.continuous = continuous;
      const BodyId sensor = world.add_body(gate);
      const BodyId bullet =
          world.add_body({.shape = Sphere{0.01}, .position = {-1 - 0.6 * phase, 0, 0}, .velocity = {400, 0, 0}});
      // It passes the gate beside the hole that is no part of it, and one that is filtered.
      world.add_body({.shape = Sphere{0.01}, .position = {-1, 1.02, 0}, .velocity = {400, 0, 0}});
      world.add_body(
          {.shape = Sphere{0.01}, .position = {-1, 0.5, 0}, .velocity = {400, 0, 0}, .filter = {.category = 0}});
      const std::vector<SensorEvent> passages = sensor_events_of(world, 3);
      if (continuous) {
        expect_passed(passages, sensor, bullet);
      } else {
        EXPECT_LE(passages.size(), 2u);
        EXPECT_TRUE(phase % 10 != 5 || passages.empty());
      }
    }
  }
}

// However a step ends as they come to touch: a slow body is told of once.
TEST(SensorSight, TellsOfASlowBodyOnce) {
  for (const double start : {-2.0, -1.0, -0.25, -0.25 - 1e-9, -0.25 + 1e-9}) {
    for (const double speed : {0.5, 1.0, 2.0}) {
      for (const bool turned : {false, true}) {
        World world = without_gravity();
        BodyDef gate = sensor_at({0, 0, 0}, Box{{0.2, 1, 1}});
        gate.continuous = true;
        const BodyId sensor = world.add_body(gate);
        const double side = turned ? -1 : 1;
        const BodyId ball =
            world.add_body({.shape = Sphere{0.05}, .position = {side * start, 0, 0}, .velocity = {side * speed, 0, 0}});
        SCOPED_TRACE(testing::Message() << "from " << start << " at " << speed);
        expect_passed(sensor_events_of(world, static_cast<int>((0.5 - start) / speed / dt)), sensor, ball);
      }
    }
  }
}

TEST(SensorSight, SeesWhatItPassesItself) {
  World world = without_gravity();
  BodyDef bullet = sensor_at({-1, 0, 0}, Sphere{0.01});
  bullet.type = BodyType::Kinematic;
  bullet.velocity = {400, 0, 0};
  bullet.continuous = bullet.notices_static = true;
  const BodyId sensor = world.add_body(bullet);
  const BodyId wall = world.add_body(static_box({0, 0, 0}, {0.005, 1, 1}));
  expect_passed(sensor_events_of(world, 2), sensor, wall);
}

// A rod of 2 m sweeps over a ball between two steps: from 0 to 0.8 rad, over what lies at 0.4.
TEST(SensorSight, SeesWhatTurnsThroughIt) {
  World world = without_gravity();
  BodyDef ball = sensor_at({0.9 * std::cos(0.4), 0.9 * std::sin(0.4), 0}, Sphere{0.02});
  ball.continuous = true;
  const BodyId sensor = world.add_body(ball);
  const BodyId rod = world.add_body(
      {.type = BodyType::Kinematic, .shape = Box{{1, 0.02, 0.02}}, .angular_velocity = {0, 0, 0.8 / dt}});
  expect_passed(sensor_events_of(world, 1), sensor, rod);
}

TEST(SensorSight, DoesNotTakeAMoveByHandForAPass) {
  World world = without_gravity();
  BodyDef gate = sensor_at({0, 0, 0}, Box{{0.005, 1, 1}});
  gate.continuous = true;
  world.add_body(gate);
  const BodyId ball = world.add_body({.shape = Sphere{0.01}, .position = {-1, 0, 0}});
  world.step(dt);
  world.set_pose(ball, {{1, 0, 0}, Quaternion::Identity()});
  EXPECT_TRUE(sensor_events_of(world, 2).empty());
}

TEST(SensorSight, TellsTheChildrenThatMet) {
  World world = without_gravity();
  const Compound pair{{{.shape = Sphere{0.1}, .position = {0, 0, 0}}, {.shape = Sphere{0.1}, .position = {2, 0, 0}}}};
  world.add_body(sensor_at({0, 0, 0}, pair));
  world.add_body({.type = BodyType::Kinematic, .shape = pair, .position = {0, 0.5, 0}, .velocity = {0, -60, 0}});
  world.add_body({.type = BodyType::Kinematic, .shape = pair, .position = {2, -0.5, 0}, .velocity = {0, 60, 0}});
  world.add_body({.type = BodyType::Kinematic, .shape = pair, .position = {-2, 0, 0.05}});
  world.step(1.0 / 120);
  const auto events = world.sensor_events();
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(std::pair(events[0].child_sensor, events[0].child_body), std::pair(0u, 0u));
  EXPECT_EQ(std::pair(events[1].child_sensor, events[1].child_body), std::pair(1u, 0u));
  EXPECT_EQ(std::pair(events[2].child_sensor, events[2].child_body), std::pair(0u, 1u));
}

TEST(SensorSight, IsTheSameAfterARestore) {
  World world = without_gravity();
  BodyDef gate = sensor_at({0, 0, 0}, Box{{0.005, 1, 1}});
  gate.continuous = gate.notices_static = gate.notices_sensors = true;
  const BodyId sensor = world.add_body(gate);
  const BodyId bullet = world.add_body({.shape = Sphere{0.01}, .position = {-10, 0, 0}, .velocity = {400, 0, 0}});
  world.add_body(static_box({0, 0.5, 0}, {0.1, 0.1, 0.1}));
  world.step(dt);
  Snapshot snapshot;
  world.save(snapshot);
  World other;
  other.restore(snapshot);
  EXPECT_TRUE(other.definition(sensor).notices_static && other.definition(sensor).notices_sensors);
  expect_passed(sensor_events_of(other, 1), sensor, bullet);
  expect_passed(sensor_events_of(world, 1), sensor, bullet);
}

}  // namespace
}  // namespace atl::test::sensor_sight_test
