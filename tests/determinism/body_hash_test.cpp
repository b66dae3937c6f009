// Hashes by body: they tell whose state differs, and of what kind.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "support/expect_error.h"
#include "support/scene_run.h"

namespace atl::test::body_hash_test {
namespace {

double next(double value) { return std::nextafter(value, std::numeric_limits<double>::infinity()); }

struct Rig {
  World world;
  std::vector<BodyId> ids;  // the ground, a stack of three, a pendulum of two links, a ball in flight
  std::vector<JointId> joints;

  Rig() : world({.settings = {.sleeping = true}}) {
    ids.push_back(world.add_body(ground()));
    for (const BodyId id : add_stack(world, 3)) ids.push_back(id);
    const BodyId post = world.add_body(static_box({5, 0, 5}, {0.1, 0.1, 0.1}));
    BodyId above = post;
    for (int i = 0; i < 2; ++i) {
      ids.push_back(world.add_body(sphere({5, 0, 4.0 - i}, 0.2)));
      joints.push_back(world.add_joint({.first = above, .second = ids.back(), .frame_second = {{0, 0, 1}}}));
      above = ids.back();
    }
    ids.push_back(world.add_body(sphere({10, 0, 30})));
    run(world, 20);
  }
};

/// Places of the bodies whose hashes a change makes differ.
std::vector<std::uint32_t> changed_by(const std::function<void(Rig&)>& change) {
  Rig plain, changed;
  change(changed);
  const std::vector<BodyHash> a = plain.world.body_hashes();
  const std::vector<BodyHash> b = changed.world.body_hashes();
  EXPECT_NE(plain.world.state_hash(), changed.world.state_hash());
  std::vector<std::uint32_t> bodies;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    if (!(a[i] == b[i])) bodies.push_back(i);
  }
  return bodies;
}

// A change that is taken back leaves no trace in the hash, whatever the world still keeps of it.
TEST(BodyHash, WhatIsTakenBackDoesNotShow) {
  const auto is_as_before = [](const auto& change, const auto& take_back) {
    Rig plain, changed;
    change(changed);
    EXPECT_NE(plain.world.state_hash(), changed.world.state_hash());
    take_back(changed);
    take_back(plain);  // which wakes
    EXPECT_EQ(plain.world.body_hashes(), changed.world.body_hashes());
  };
  const auto runs = [](double speed) {
    return [speed](Rig& rig) { rig.world.set_surface_velocity(rig.ids[0], {speed, 0, 0}); };
  };
  const auto may_touch = [](bool may) {
    return [may](Rig& rig) { rig.world.set_collision_enabled(rig.ids[0], rig.ids[6], may); };
  };
  is_as_before(runs(1), runs(0));
  is_as_before(may_touch(false), may_touch(true));
}

TEST(BodyHash, OneAtATimeIsWhatAllTogetherAre) {
  for (const char* text : {"pile:bodies=40", "ragdolls:count=2", "conveyor:boxes=3", "stack:height=30"}) {
    SceneRun scene(text);
    for (int i = 0; i < 60; ++i) {
      scene.world.step(scene.scene.dt);
      if (i % 20 != 19) continue;
      const std::vector<BodyHash> all = scene.world.body_hashes();
      for (const BodyId id : scene.ids) EXPECT_EQ(scene.world.body_hash(id), all[id.index]) << text << " " << id.index;
    }
  }
}

TEST(BodyHash, AChangeShowsOnItsBodyAlone) {
  for (const std::size_t place : {std::size_t{2}, std::size_t{6}}) {
    const auto velocity = [=](Rig& rig) {
      Vector3 linear = rig.world.velocity(rig.ids[place]);
      linear.y() = next(linear.y());
      rig.world.set_velocity(rig.ids[place], linear, rig.world.angular_velocity(rig.ids[place]));
    };
    const auto force = [=](Rig& rig) { rig.world.apply_force(rig.ids[place], {1, 0, 0}); };
    const std::uint32_t index = Rig().ids[place].index;
    EXPECT_EQ(changed_by(velocity), std::vector{index});
    EXPECT_EQ(changed_by(force), std::vector{index});
  }
  EXPECT_EQ(changed_by([](Rig& rig) { rig.world.set_filter(rig.ids[6], {.group = 3}); }),
            (std::vector<std::uint32_t>{7}));
}

TEST(BodyHash, PartsAreTold) {
  Rig plain, changed;
  changed.world.apply_force(changed.ids[6], {1, 0, 0});
  const BodyHash a = plain.world.body_hash(plain.ids[6]);
  const BodyHash b = changed.world.body_hash(changed.ids[6]);
  EXPECT_NE(a.input, b.input);
  EXPECT_EQ(a.pose, b.pose);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.contacts, b.contacts);
  EXPECT_EQ(a.joints, b.joints);
}

TEST(BodyHash, ContactsAndJointsCountForTheDynamicBodiesTheyHold) {
  EXPECT_EQ(changed_by([](Rig& rig) {
              rig.world.set_joint_enabled(rig.joints[1], false);
              rig.world.set_joint_enabled(rig.joints[1], true);
            }),
            (std::vector<std::uint32_t>{5, 6}))
      << "both links";
  EXPECT_EQ(changed_by([](Rig& rig) {
              rig.world.set_joint_enabled(rig.joints[0], false);
              rig.world.set_joint_enabled(rig.joints[0], true);
            }),
            (std::vector<std::uint32_t>{5}))
      << "a post doesn't count";
}

TEST(BodyHash, BodiesThatMayNotTouchAreToldOnBoth) {
  EXPECT_EQ(changed_by([](Rig& rig) { rig.world.set_collision_enabled(rig.ids[3], rig.ids[6], false); }),
            (std::vector<std::uint32_t>{3, 7}));
}

TEST(BodyHash, RemovedBodiesHaveNone) {
  Rig rig;
  rig.world.remove_body(rig.ids[6]);
  EXPECT_EQ(rig.world.body_hashes()[rig.ids[6].index], BodyHash{});
  EXPECT_THROW(rig.world.body_hash(rig.ids[6]), Error);
}

}  // namespace
}  // namespace atl::test::body_hash_test
