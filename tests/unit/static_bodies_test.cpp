// Many static bodies: their boxes wait until something asks for them, and what is alike of them is kept once. Nobody
// may see that.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <thread>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

constexpr int side = 150;  // enough for a tree that is built in parts

/// A floor of boxes, 1 m apart, whose tops are at z = 0.
std::vector<BodyId> add_floor(World& world) {
  std::vector<BodyId> ids;
  for (int i = 0; i < side * side; ++i) {
    ids.push_back(world.add_body(static_box({1.0 * (i % side), 1.0 * (i / side), -0.5}, {0.5, 0.5, 0.5})));
  }
  return ids;
}

std::optional<BodyId> below(const World& world, double x, double y) {
  const auto hit = Queries(world).cast_ray({.origin = {x, y, 5}, .direction = {0, 0, -1}});
  return hit ? std::optional(hit->body) : std::nullopt;
}

TEST(StaticBodies, AreFoundBeforeTheFirstStep) {
  World world({.threads = 2});
  const std::vector<BodyId> floor = add_floor(world);
  EXPECT_EQ(below(world, 3, 4), floor[4 * side + 3]);
  const BodyId late = world.add_body(static_box({3, 4, 1}, {0.1, 0.1, 0.1}));
  EXPECT_EQ(below(world, 3, 4), late);
  EXPECT_EQ(Queries(world).overlapping({.position = {3, 4, 1}}), std::vector{late});
}

TEST(StaticBodies, AreFoundByManyThreadsAtOnce) {
  World world({.threads = 2});
  const std::vector<BodyId> floor = add_floor(world);
  std::vector<int> found(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < found.size(); ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < side; ++i) found[t] += below(world, i, i) == floor[static_cast<std::size_t>(i * (side + 1))];
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(found, std::vector<int>(4, side));
}

TEST(StaticBodies, MoveAndGoBeforeTheyWereAskedFor) {
  World world;
  const std::vector<BodyId> floor = add_floor(world);
  world.remove_body(floor[0]);
  world.remove_body(floor[side * side - 1]);
  world.set_pose(floor[1], {{-5, -5, 0}, Quaternion::Identity()});
  EXPECT_EQ(below(world, 0, 0), std::nullopt);
  EXPECT_EQ(below(world, 1, 0), std::nullopt);
  EXPECT_EQ(below(world, -5, -5), floor[1]);
  world.set_pose(floor[1], {{-7, -7, 0}, Quaternion::Identity()});
  EXPECT_EQ(below(world, -5, -5), std::nullopt);
  EXPECT_EQ(below(world, -7, -7), floor[1]);
  const BodyId again = world.add_body(static_box({0, 0, 0}, {0.5, 0.5, 0.5}));
  EXPECT_EQ(below(world, 0, 0), again);
}

// Balls fall on a floor, of which some goes, comes and moves on the way, and before the first step.
struct Fall {
  World world;
  std::vector<BodyId> floor;

  explicit Fall(int threads) : world({.threads = threads}), floor(add_floor(world)) {
    world.remove_body(floor[3]);
    world.set_pose(floor[2 * side + 2], {{2, 2, -0.4}, Quaternion::Identity()});
    for (int i = 0; i < 20; ++i) world.add_body(sphere({0.3 + 1.3 * i, 0.2 + 1.1 * i, 0.7}));
    world.add_body(sphere({3, 0, 0.7}, 0.3));  // where there is a hole
  }
  std::vector<std::uint64_t> run(bool asks) {
    std::vector<std::uint64_t> hashes;
    for (int step = 0; step < 40; ++step) {
      if (asks) below(world, step, step);
      if (step == 20) {
        world.remove_body(floor[5 * side + 5]);
        world.add_body(static_box({5, 5, -0.3}, {0.5, 0.5, 0.5}));
        for (int i = 0; i < 5000; ++i) world.add_body(static_box({1.0 * i, -10, 0}, {0.2, 0.2, 0.2}));
      }
      world.step(dt);
      hashes.push_back(world.state_hash());
    }
    return hashes;
  }
};

TEST(StaticBodies, ActTheSameWheneverTheyAreAskedFor) {
  const std::vector<std::uint64_t> expected = Fall(1).run(false);
  EXPECT_EQ(Fall(1).run(true), expected);
  for (const int threads : {2, 3, 4}) EXPECT_EQ(Fall(threads).run(threads == 3), expected) << threads;
  Fall fall(2);
  fall.run(false);
  EXPECT_LT(fall.world.contact_forces().size(), 100u);
  EXPECT_GT(fall.world.contact_forces().size(), 15u);
}

TEST(StaticBodies, ComeBackWithASnapshotTakenBeforeTheyWereAskedFor) {
  Fall fall(2);
  Snapshot snapshot;
  fall.world.save(snapshot);
  const std::uint64_t hash = fall.world.state_hash();
  const std::vector<std::uint64_t> expected = fall.run(false);
  fall.world.restore(snapshot);
  EXPECT_EQ(fall.world.state_hash(), hash);
  EXPECT_EQ(below(fall.world, 7, 9), fall.floor[9 * side + 7]);
  EXPECT_EQ(fall.run(true), expected);

  Fall fresh(1);
  fresh.world.step(dt);
  fresh.world.restore(snapshot);
  EXPECT_EQ(fresh.run(false), expected);
  World empty;
  empty.restore(snapshot);
  EXPECT_EQ(empty.state_hash(), hash);
  EXPECT_EQ(below(empty, 7, 9), fall.floor[9 * side + 7]);
}

// A static body out of bounds is taken out in the next step, like any other body.
TEST(StaticBodies, AreContained) {
  World world;
  const std::vector<BodyId> floor = add_floor(world);
  const BodyId stray = world.add_body(static_box({1e13, 0, 0}, {0.5, 0.5, 0.5}));
  world.set_pose(floor[1], {{1e13, 0, 0}, Quaternion::Identity()});
  EXPECT_TRUE(world.quarantined().empty());
  world.step(dt);
  ASSERT_EQ(world.quarantined().size(), 2u);
  EXPECT_TRUE(world.is_quarantined(stray));
  EXPECT_TRUE(world.is_quarantined(floor[1]));
}

// 600 bytes a body, with a tree; 2^16 bodies, so that arrays are as large as what they hold.
TEST(StaticBodies, TakeLittleRoom) {
  constexpr std::size_t count = 1 << 16;
  World world;
  for (std::size_t i = 0; i < count; ++i) {
    const double size = i % 2 == 0 ? 0.5 : 0.25;
    world.add_body(
        static_box({1.0 * static_cast<double>(i % 256), 1.0 * static_cast<double>(i / 256), 0}, {size, size, 0.5}));
  }
  world.step(dt);
  EXPECT_TRUE(below(world, 3, 4).has_value());
  std::size_t bytes = 0;
  for (const MemoryUse& use : world.memory()) bytes += use.bytes;
  EXPECT_LT(bytes, 600 * count);
}

}  // namespace
}  // namespace atl::test
