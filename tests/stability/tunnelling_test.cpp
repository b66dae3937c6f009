// Nothing passes through anything, however fast, thin or turned: at any phase of the step.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

constexpr double speed = 200;            // m/s: 3.3 m a step
constexpr double wall_thickness = 0.02;  // m
constexpr int phases = 1000;

// The wall stands at x = 0; the bullet starts well before it, so that its steps end anywhere around it.
double start_of(int phase) { return -6.0 - speed * dt * phase / phases; }

BodyDef wall() { return static_box({0, 0, 0}, {wall_thickness / 2, 20, 20}); }

TEST(Tunnelling, SphereNeverPassesAWall) {
  int through = 0;
  for (int phase = 0; phase < phases; ++phase) {
    World world({.gravity = Vector3::Zero()});
    world.add_body(wall());
    BodyDef bullet = sphere({start_of(phase), 0.01 * phase, 0}, 0.05);
    bullet.velocity = {speed, 0, 0};
    const BodyId id = world.add_body(bullet);
    for (int step = 0; step < 8; ++step) {
      world.step(dt);
      through += world.pose(id).position.x() > 0;
    }
  }
  EXPECT_EQ(through, 0);
}

TEST(Tunnelling, SpinningStickNeverPassesAWall) {
  int through = 0;
  for (int phase = 0; phase < phases; ++phase) {
    World world({.gravity = Vector3::Zero()});
    world.add_body(wall());
    const double angle = 2 * std::numbers::pi * std::fmod(0.618033988749895 * phase, 1.0);
    BodyDef stick = box({start_of(phase), 0, 0}, {0.25, 0.005, 0.005});
    stick.orientation = Eigen::AngleAxisd(angle, Vector3(0.3, 0.5, 1).normalized());
    stick.velocity = {speed, 0, 0};
    stick.angular_velocity = {20, -30, 100};
    const BodyId id = world.add_body(stick);
    for (int step = 0; step < 8; ++step) {
      world.step(dt);
      through += world.pose(id).position.x() > 0;
    }
  }
  EXPECT_EQ(through, 0);
}

TEST(Tunnelling, BulletHitsAMovingCrate) {
  for (int phase = 0; phase < 100; ++phase) {
    World world({.gravity = Vector3::Zero()});
    BodyDef crate = box({0, 0, 0}, {0.05, 0.5, 0.5});
    crate.velocity = {-3, 0, 0};
    const BodyId target = world.add_body(crate);
    BodyDef bullet = sphere({start_of(10 * phase), 0, 0}, 0.02);
    bullet.velocity = {speed, 0, 0};
    const BodyId id = world.add_body(bullet);
    const Vector3 before = momentum(world, {target, id});
    run(world, 10);
    EXPECT_LT(world.pose(id).position.x(), world.pose(target).position.x()) << "phase " << phase;
    EXPECT_NEAR((momentum(world, {target, id}) - before).norm(), 0, 1e-4 * before.norm()) << "phase " << phase;
    EXPECT_GT(world.velocity(target).x(), -3) << "phase " << phase;
  }
}

// A bullet of several parts that hits at once doesn't end the step beyond a plate that it takes along. They share the
// momentum, and part at no speed.
TEST(Tunnelling, ABulletOfPartsTakesAFreePlateAlong) {
  for (const bool round : {false, true}) {
    const ConvexShape part = round ? ConvexShape(Sphere{0.05}) : ConvexShape(Box{{0.05, 0.05, 0.05}});
    Compound parts;
    for (const double z : {-0.1, 0.1}) parts.children.push_back({.shape = part, .position = {0, 0, z}});
    for (const double thickness : {0.01, 0.04, 0.1}) {
      for (const double speed : {100.0, 300.0, 900.0}) {
        for (int phase = 0; phase < 2; ++phase) {
          for (const double mass : {0.3, 3.0}) {
            SCOPED_TRACE(testing::Message()
                         << thickness << " m, " << mass << " kg, at " << speed << ", phase " << phase);
            World world({.gravity = Vector3::Zero()});
            BodyDef plate = box({1.23 + 0.2 * speed * dt * phase, 0, 0}, {thickness / 2, 1, 1});
            plate.mass = mass;
            const BodyId target = world.add_body(plate);
            const BodyId bullet = world.add_body({.shape = parts, .velocity = {speed, 0, 0}, .mass = 1.0});
            run(world, static_cast<int>(plate.position.x() / speed / dt) + 6);
            EXPECT_LT(world.pose(bullet).position.x(), world.pose(target).position.x());
            EXPECT_NEAR(momentum(world, {target, bullet}).x(), speed, 1e-4 * speed);
            EXPECT_NEAR(world.velocity(bullet).x(), speed / (1 + mass), 0.1 * speed);
          }
        }
      }
    }
  }
}

TEST(Tunnelling, FastBodiesThatPassEachOtherMeet) {
  World world({.gravity = Vector3::Zero()});
  BodyDef left = sphere({-5, 0, 0}, 0.05);
  left.velocity = {speed, 0, 0};
  BodyDef right = sphere({5, 0, 0}, 0.05);
  right.velocity = {-speed, 0, 0};
  const BodyId a = world.add_body(left);
  const BodyId b = world.add_body(right);
  run(world, 10);
  EXPECT_LT(world.pose(a).position.x(), world.pose(b).position.x());
}

// A fast body on the ground is in contact all the time; that must not hold it up.
TEST(Tunnelling, SlidingBodiesKeepTheirSpeed) {
  World world;
  world.add_body(ground(0));
  BodyDef slider = box({0, 0, 0.5});
  slider.velocity = {60, 0, 0};
  slider.material.friction = 0;
  const BodyId id = world.add_body(slider);
  const StepReport report = run(world, 120);
  EXPECT_GT(report.counts.swept, 0);
  EXPECT_NEAR(world.pose(id).position.x(), 60 * 2.0, 1e-3 * 120);
}

TEST(Tunnelling, OnlyFastBodiesAreSwept) {
  World world;
  world.add_body(ground());
  add_stack(world, 3);
  EXPECT_EQ(run(world, 60).counts.swept, 0);
  BodyDef bullet = sphere({-100, 0, 50}, 0.05);
  bullet.velocity = {speed, 0, 0};
  world.add_body(bullet);
  EXPECT_EQ(run(world, 3).counts.swept, 1);
}

// Three walls, and a shower of boxes, spheres and dumbbells that fly at them and at each other.
std::vector<BodyId> add_shower(World& world) {
  for (int side : {-1, 0, 1}) world.add_body(static_box({6.0 * side, 0, 0}, {wall_thickness / 2, 20, 20}));
  std::vector<BodyId> shower;
  for (int i = 0; i < 216; ++i) {
    const Vector3 place(i % 6 - 2.5, i / 6 % 6 - 2.5, i / 36 - 2.5);
    BodyDef body = i % 3 == 0 ? sphere(place, 0.3) : box(place, {0.3, 0.2, 0.1});
    if (i % 5 == 0) {
      body.shape =
          Compound{{{.shape = Sphere{0.2}, .position = {-0.2, 0, 0}}, {.shape = Sphere{0.2}, .position = {0.2, 0, 0}}}};
    }
    body.velocity = 40 * Vector3(std::sin(7.0 * i), std::sin(11.0 * i), std::sin(13.0 * i));
    body.angular_velocity = 20 * Vector3(std::sin(17.0 * i), std::sin(19.0 * i), std::sin(23.0 * i));
    shower.push_back(world.add_body(body));
  }
  return shower;
}

// Many fast bodies find their neighbours by contacts; a few among many slow ones find them by the AABB tree.
TEST(Tunnelling, WhatIsNearIsTheSameByContactsAndByTree) {
  World alone({.gravity = Vector3::Zero()}), in_crowd({.gravity = Vector3::Zero()});
  const std::vector<BodyId> shower = add_shower(alone);
  ASSERT_EQ(add_shower(in_crowd), shower);
  for (int i = 0; i < 216 * 20; ++i) {
    BodyDef slow = sphere(Vector3(100 + i % 16, i / 16 % 16, i / 256), 0.1);
    slow.velocity = {0.1, 0, 0};
    in_crowd.add_body(slow);
  }
  std::int64_t stopped = 0;
  for (int step = 0; step < 60; ++step) {
    const StepCounts counts = alone.step(dt).counts;
    EXPECT_EQ(in_crowd.step(dt).counts.stopped, counts.stopped) << step;
    stopped += counts.stopped;
    for (const BodyId id : shower) {
      ASSERT_EQ(alone.pose(id).position, in_crowd.pose(id).position) << "body " << id.index << " in step " << step;
    }
  }
  EXPECT_GT(stopped, 50);
}

TEST(Tunnelling, ContinuousBodiesAreSweptAtAnySpeed) {
  World world({.gravity = Vector3::Zero()});
  BodyDef slow = sphere({0, 0, 0});
  slow.velocity = {0.1, 0, 0};
  slow.continuous = true;
  world.add_body(slow);
  EXPECT_EQ(run(world, 2).counts.swept, 1);
}

}  // namespace
}  // namespace atl::test
