// A hash that misses something passes where it should fail: each part of the state that the future depends on, changed
// alone and as little as it can be, must change the hash.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <vector>

#include "support/bodies.h"

namespace atl::test::state_hash_test {
namespace {

double next(double value) { return std::nextafter(value, std::numeric_limits<double>::infinity()); }

struct Crates {
  World world;
  std::vector<BodyId> ids;

  Crates() {
    world.add_body(ground());
    ids = add_stack(world, 3);
    BodyDef thrown = sphere({4, 0, 3});
    thrown.velocity = {1, 2, 3};
    thrown.angular_velocity = {0.1, 0.2, 0.3};
    ids.push_back(world.add_body(thrown));
  }
};

/// Hash after `steps` and then a change.
std::uint64_t hash_after(int steps, const std::function<void(Crates&)>& change = {}) {
  Crates crates;
  run(crates.world, steps);
  if (change) change(crates);
  return crates.world.state_hash();
}

TEST(StateHash, IsAFunctionOfTheStateAlone) {
  for (const int steps : {0, 1, 60}) EXPECT_EQ(hash_after(steps), hash_after(steps)) << steps;
  const Crates crates;
  EXPECT_EQ(crates.world.state_hash(), crates.world.state_hash()) << "asking does not change it";
}

TEST(StateHash, SeesTheLastBitOfEveryCoordinate) {
  std::set<std::uint64_t> hashes = {hash_after(30)};
  std::size_t changes = 0;
  for (const std::size_t body : {std::size_t{0}, std::size_t{3}}) {
    for (int axis = 0; axis < 3; ++axis) {
      ++changes;
      hashes.insert(hash_after(30, [&](Crates& crates) {
        Pose pose = crates.world.pose(crates.ids[body]);
        pose.position[axis] = next(pose.position[axis]);
        crates.world.set_pose(crates.ids[body], pose);
      }));
      for (const bool angular : {false, true}) {
        ++changes;
        hashes.insert(hash_after(30, [&](Crates& crates) {
          Vector3 linear = crates.world.velocity(crates.ids[body]);
          Vector3 spin = crates.world.angular_velocity(crates.ids[body]);
          double& value = angular ? spin[axis] : linear[axis];
          value = next(value);
          crates.world.set_velocity(crates.ids[body], linear, spin);
        }));
      }
    }
  }
  EXPECT_EQ(hashes.size(), changes + 1);
}

TEST(StateHash, SeesOrientation) {
  std::set<std::uint64_t> hashes = {hash_after(30)};
  for (int axis = 0; axis < 3; ++axis) {
    hashes.insert(hash_after(30, [&](Crates& crates) {
      Pose pose = crates.world.pose(crates.ids[3]);
      pose.orientation = pose.orientation * Quaternion(Eigen::AngleAxisd(1e-12, Vector3::Unit(axis)));
      crates.world.set_pose(crates.ids[3], pose);
    }));
  }
  EXPECT_EQ(hashes.size(), 4u);
}

TEST(StateHash, SeesWarmStartImpulses) {
  // The same poses and velocities, once with the contacts' history and once fresh.
  Crates settled;
  run(settled.world, 60);
  World fresh;
  fresh.add_body(ground());
  for (std::size_t i = 0; i < settled.ids.size(); ++i) {
    const BodyId id = settled.ids[i];
    BodyDef def = i < 3 ? box({0, 0, 0}) : sphere({0, 0, 0});
    const Pose pose = settled.world.pose(id);
    def.position = pose.position;
    def.orientation = pose.orientation;
    def.velocity = settled.world.velocity(id);
    def.angular_velocity = settled.world.angular_velocity(id);
    fresh.add_body(def);
  }
  EXPECT_NE(settled.world.state_hash(), fresh.state_hash());
}

TEST(StateHash, SeesSettingsGravityAndForcesThatAwaitTheNextStep) {
  std::set<std::uint64_t> hashes = {hash_after(10)};
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.apply_force(crates.ids[3], {1, 0, 0}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.apply_force(crates.ids[3], {0, 0, 0}, {1, 0, 0}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_gravity({0, 0, -9.8}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_settings({.substeps = 5}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_settings({.tolerance = 1e-9}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_settings({.correction = 0.25}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_settings({.slop = 1e-3}); }));
  for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    hashes.insert(hash_after(10, [=](Crates& crates) { crates.world.set_settings({.stabilisation = stabilisation}); }));
  }
  hashes.insert(
      hash_after(10, [](Crates& crates) { crates.world.set_settings({.joint_solver = JointSolver::Direct}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_settings({.joint_hertz = 20}); }));
  hashes.insert(hash_after(10, [](Crates& crates) { crates.world.set_settings({.joint_damping_ratio = 3}); }));
  EXPECT_EQ(hashes.size(), 13u);
}

TEST(StateHash, IsBlindToAProfile) {
  EXPECT_EQ(hash_after(10, [](Crates& crates) { crates.world.set_settings({.profile = true}); }), hash_after(10));
}

TEST(StateHash, SeesSurfaces) {
  // A body far away whose surface nothing has touched yet.
  const auto hash_with = [](const BodyDef& def) {
    return hash_after(10, [&](Crates& crates) { crates.world.add_body(def); });
  };
  BodyDef belt = static_box({100, 0, 0}, {1, 1, 1});
  std::set<std::uint64_t> hashes = {hash_with(belt)};
  for (int axis = 0; axis < 3; ++axis) {
    BodyDef other = belt;
    other.surface_velocity = 1e-300 * Vector3::Unit(axis);
    hashes.insert(hash_with(other));
  }
  belt.material.rolling_friction = 1e-300;
  hashes.insert(hash_with(belt));
  belt.material = {.torsional_friction = 1e-300};
  hashes.insert(hash_with(belt));
  EXPECT_EQ(hashes.size(), 6u);
}

TEST(StateHash, SeesWhatMayTouch) {
  // The filters are those of bodies far from each other, so that they have no effect yet.
  const auto hash_with = [](const CollisionFilter& filter) {
    return hash_after(10, [&](Crates& crates) { crates.world.set_filter(crates.ids[3], filter); });
  };
  std::set<std::uint64_t> hashes = {hash_with({}), hash_with({.category = 3}), hash_with({.mask = ~2u}),
                                    hash_with({.group = -1})};
  for (const std::size_t other : {std::size_t{0}, std::size_t{1}}) {
    hashes.insert(hash_after(
        10, [=](Crates& crates) { crates.world.set_collision_enabled(crates.ids[3], crates.ids[other], false); }));
  }
  EXPECT_EQ(hashes.size(), 6u);
}

TEST(StateHash, DoesNotSeeInWhichOrderBodiesWereToldNotToTouch) {
  const auto hash_with = [](std::size_t first, std::size_t second) {
    return hash_after(0, [=](Crates& crates) {
      crates.world.set_collision_enabled(crates.ids[first], crates.ids[3], false);
      crates.world.set_collision_enabled(crates.ids[3], crates.ids[second], false);
    });
  };
  EXPECT_EQ(hash_with(0, 1), hash_with(1, 0));
}

TEST(StateHash, ForgetsTheSurfaceOfARemovedBody) {
  // The same id and place in the free list, once with a belt that is gone.
  const auto hash_without = [](const Vector3& surface_velocity) {
    return hash_after(10, [&](Crates& crates) {
      BodyDef belt = static_box({100, 0, 0}, {1, 1, 1});
      belt.surface_velocity = surface_velocity;
      crates.world.remove_body(crates.world.add_body(belt));
    });
  };
  EXPECT_EQ(hash_without({0, 0, 0}), hash_without({1, 0, 0}));
}

TEST(StateHash, SeesSleepTimers) {
  // At rest without gravity nothing moves: only the time at rest tells one step from the next.
  World world({.gravity = Vector3::Zero(), .settings = {.sleeping = true}});
  world.add_body(box({0, 0, 0}));
  std::set<std::uint64_t> hashes;
  for (int i = 0; i < 10; ++i) {
    world.step(dt);
    hashes.insert(world.state_hash());
  }
  EXPECT_EQ(hashes.size(), 10u);
}

TEST(StateHash, SeesWhichIdComesNext) {
  // Both worlds hold the same two bodies, but the next one they add gets another index.
  const auto remove_two = [](std::size_t first, std::size_t second) {
    World world;
    std::vector<BodyId> ids;
    for (int i = 0; i < 4; ++i) ids.push_back(world.add_body(box({2.0 * i, 0, 0})));
    world.remove_body(ids[first]);
    world.remove_body(ids[second]);
    const std::uint64_t hash = world.state_hash();
    return std::pair(hash, world.add_body(box({0, 9, 0})).index);
  };
  const auto [hash_a, next_a] = remove_two(1, 2);
  const auto [hash_b, next_b] = remove_two(2, 1);
  EXPECT_EQ(hash_a == hash_b, next_a == next_b);
}

TEST(StateHash, OneUlpOfVelocityTellsInEveryFollowingStep) {
  Crates a, b;
  Vector3 velocity = b.world.velocity(b.ids[3]);
  velocity.x() = next(velocity.x());
  b.world.set_velocity(b.ids[3], velocity, b.world.angular_velocity(b.ids[3]));
  for (int i = 0; i < 10; ++i) {
    EXPECT_NE(a.world.state_hash(), b.world.state_hash()) << "after step " << i;
    a.world.step(dt);
    b.world.step(dt);
  }
}

}  // namespace
}  // namespace atl::test::state_hash_test
