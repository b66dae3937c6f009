// Who may touch whom, and being told who does.

#include <gtest/gtest.h>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

// Drops a ball on a plate; the ball falls through if they may not touch.
bool lands(const CollisionFilter& ball, const CollisionFilter& plate) {
  World world;
  BodyDef floor = static_box({0, 0, -0.5}, {2, 2, 0.5});
  floor.filter = plate;
  world.add_body(floor);
  BodyDef falling = sphere({0, 0, 0.6});
  falling.filter = ball;
  const BodyId id = world.add_body(falling);
  run(world, 60);
  return world.pose(id).position.z() > 0;
}

TEST(CollisionFilter, MasksOfBothMustAdmitTheOther) {
  EXPECT_TRUE(lands({}, {}));
  EXPECT_TRUE(lands({.category = 2, .mask = 4}, {.category = 4, .mask = 2}));
  EXPECT_FALSE(lands({.category = 2, .mask = 4}, {.category = 4, .mask = 1}));
  EXPECT_FALSE(lands({.category = 2, .mask = 1}, {.category = 4, .mask = 2}));
}

TEST(CollisionFilter, ASharedGroupGoesBeforeMasks) {
  EXPECT_FALSE(lands({.group = -3}, {.group = -3}));
  EXPECT_TRUE(lands({.mask = 0, .group = 3}, {.group = 3}));
  EXPECT_TRUE(lands({.group = -3}, {.group = -4}));
}

TEST(CollisionFilter, CanBeChangedWhileTouching) {
  World world;
  world.add_body(static_box({0, 0, -0.5}, {2, 2, 0.5}));
  const BodyId ball = world.add_body(sphere({0, 0, 0.5}));
  run(world, 30);
  EXPECT_GT(world.pose(ball).position.z(), 0.4);
  world.set_filter(ball, {.mask = 0});
  run(world, 60);
  EXPECT_LT(world.pose(ball).position.z(), -1);
}

TEST(CollisionFilter, PairsCanBeTurnedOffAndOn) {
  World world;
  const BodyId floor = world.add_body(static_box({0, 0, -0.5}, {2, 2, 0.5}));
  const BodyId ball = world.add_body(sphere({0, 0, 0.5}));
  const BodyId other = world.add_body(sphere({1.2, 0, 0.5}));
  world.set_collision_enabled(floor, ball, false);
  run(world, 20);
  EXPECT_LT(world.pose(ball).position.z(), 0.3);
  EXPECT_GT(world.pose(other).position.z(), 0.4);
  world.set_collision_enabled(ball, floor, true);
  run(world, 120);
  EXPECT_GT(world.pose(ball).position.z(), 0.4);
  expect_error([&] { world.set_collision_enabled(ball, ball, false); }, {"set_collision_enabled", "two"});
}

// The index of a removed body is used again: what was said about the old one must not hold for the new.
TEST(CollisionFilter, EndsWithTheBody) {
  World world;
  const BodyId floor = world.add_body(static_box({0, 0, -0.5}, {2, 2, 0.5}));
  const BodyId first = world.add_body(sphere({0, 0, 0.5}));
  world.set_collision_enabled(floor, first, false);
  world.remove_body(first);
  const BodyId second = world.add_body(sphere({0, 0, 0.5}));
  EXPECT_EQ(second.index, first.index);
  run(world, 60);
  EXPECT_GT(world.pose(second).position.z(), 0.4);
}

TEST(ContactEvents, BeginAndEndOnce) {
  World world({.settings = {.contact_events = true}});
  const BodyId floor = world.add_body(ground());
  BodyDef falling = box({0, 0, 0.6});
  const BodyId crate = world.add_body(falling);
  int began = 0;
  int ended = 0;
  const auto watch = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      world.step(dt);
      for (const ContactEvent& event : world.contact_events()) {
        EXPECT_EQ(event.a, floor);
        EXPECT_EQ(event.b, crate);
        (event.began ? began : ended) += 1;
      }
    }
  };
  watch(60);
  EXPECT_EQ(began, 1);
  EXPECT_EQ(ended, 0);
  world.set_velocity(crate, {0, 0, 5}, Vector3::Zero());
  watch(20);
  EXPECT_EQ(began, 1);
  EXPECT_EQ(ended, 1);
}

TEST(ContactEvents, ThatNobodyAskedForAreRefusedNotEmpty) {
  World world;
  world.add_body(ground());
  world.add_body(box({0, 0, 0.5}));
  run(world, 5);
  EXPECT_THROW(world.contact_events(), Error);
}

}  // namespace
}  // namespace atl::test
