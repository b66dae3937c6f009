// A world's result is its own: other worlds in the process, the thread it runs on and a move change nothing.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "support/bodies.h"
#include "support/random.h"
#include "support/scene_run.h"

namespace atl::test::independence_test {
namespace {

constexpr std::string_view scene = "islands:count=8,base=5";
constexpr int steps = 60;

std::uint64_t final_hash(const WorldDef& def = {}) {
  SceneRun islands(scene, def);
  run(islands.world, steps);
  return islands.world.state_hash();
}

TEST(Independence, WorldsThatStepAtTheSameTimeDoNotMix) {
  const std::uint64_t expected = final_hash();
  std::atomic<bool> stop = false;
  std::thread busy([&stop] {
    SceneRun pile("pile:bodies=100", {.threads = 2});
    while (!stop) pile.world.step(dt);
  });
  std::vector<std::uint64_t> hashes(2);
  std::vector<std::thread> threads;
  for (std::uint64_t& hash : hashes) {
    threads.emplace_back([&hash] { hash = final_hash({.threads = 2}); });
  }
  for (std::thread& thread : threads) thread.join();
  stop = true;
  busy.join();
  for (const std::uint64_t hash : hashes) EXPECT_EQ(hash, expected);
}

TEST(Independence, WorldsThatTakeTurnsDoNotMix) {
  const std::uint64_t expected = final_hash();
  SceneRun first(scene), second(scene), other("pile:bodies=50");
  for (int i = 0; i < steps; ++i) {
    first.world.step(dt);
    other.world.step(dt);
    second.world.step(dt);
  }
  EXPECT_EQ(first.world.state_hash(), expected);
  EXPECT_EQ(second.world.state_hash(), expected);
}

TEST(Independence, MovedWorldContinuesFromAnyThread) {
  const std::uint64_t expected = final_hash();
  SceneRun islands(scene);
  run(islands.world, steps / 2);
  World moved = std::move(islands.world);
  std::thread([&moved] { run(moved, steps - steps / 2); }).join();
  EXPECT_EQ(moved.state_hash(), expected);
}

TEST(Independence, ReadingStateBetweenStepsChangesNothing) {
  const std::uint64_t expected = final_hash();
  SceneRun islands(scene);
  for (int i = 0; i < steps; ++i) {
    islands.world.step(dt);
    islands.penetration();
    (void)islands.world.contact_forces();
    (void)islands.world.state_hash();
  }
  EXPECT_EQ(islands.world.state_hash(), expected);
}

TEST(Independence, ForcesThatAreDueDoNotDependOnTheOrderOfOtherBodies) {
  // A far bystander, added last and removed again, leaves the result of the others as it was.
  const auto positions = [](bool bystander) {
    World world;
    world.add_body(ground());
    const std::vector<BodyId> stack = add_stack(world, 4);
    if (bystander) world.remove_body(world.add_body(box({100, 0, 0.5})));
    run(world, steps);
    return world.pose(stack.back()).position;
  };
  EXPECT_EQ(positions(false), positions(true));
}

// The kernels of a group of islands depend on all of its contacts; the result of one contact must not.
TEST(Independence, ABeltAndARollingBallFarAwayChangeNoBitOfOthers) {
  for (const Stabilisation stabilisation :
       {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    const auto trail = [=](bool belt) {
      World world({.settings = {.stabilisation = stabilisation}});
      world.add_body(ground());
      std::vector<BodyId> ids = add_stack(world, 4);
      BodyDef ball = sphere({-1, 0.2, 2.5}, 0.3);
      ball.velocity = {4, 0, 0};
      ids.push_back(world.add_body(ball));
      BodyDef platform = static_box({100, 0, 0.5}, {5, 5, 0.5});
      if (belt) platform.surface_velocity = {1, 2, 0};
      world.add_body(platform);
      world.add_body(box({100, 0, 1.5}));
      BodyDef other = sphere({102, 0, 1.5});
      if (belt) other.material.rolling_friction = other.material.torsional_friction = 0.1;
      world.add_body(other);
      std::vector<double> places;
      for (int i = 0; i < steps; ++i) {
        world.step(dt);
        for (const BodyId id : ids) {
          for (const double x : world.pose(id).position) places.push_back(x);
          for (const double x : world.angular_velocity(id)) places.push_back(x);
        }
      }
      return places;
    };
    EXPECT_EQ(trail(true), trail(false)) << static_cast<int>(stabilisation);
  }
}

// Contacts of several islands share lanes, and what is struck is looked at again: none but its own contacts.
TEST(Independence, HeapsThatAreStruckChangeNoBitOfOthers) {
  const auto add_heap = [](World& world, double x, std::uint32_t seed) {
    Random random(seed);
    std::vector<BodyId> ids;
    for (int i = 0; i < 6; ++i) {
      const double size = random.real(0.2, 0.5);
      BodyDef body = random.chance(0.5) ? sphere({}, size) : box({}, Vector3::Constant(size));
      body.position = {x + random.real(-0.2, 0.2), random.real(-0.2, 0.2), 0.6 + 1.1 * i};
      body.density = random.magnitude(1e3, 1e6);
      ids.push_back(world.add_body(body));
    }
    return ids;
  };
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    World alone, among_others;
    alone.add_body(ground());
    among_others.add_body(ground());
    const std::vector<BodyId> expected = add_heap(alone, 0, seed), ids = add_heap(among_others, 0, seed);
    for (std::uint32_t i = 1; i < 9; ++i) add_heap(among_others, 30 * i, 100 * seed + i);
    for (int i = 0; i < 240; ++i) {
      alone.step(dt);
      among_others.step(dt);
    }
    for (std::size_t i = 0; i < ids.size(); ++i) {
      EXPECT_EQ(among_others.pose(ids[i]).position, alone.pose(expected[i]).position) << "seed " << seed;
      EXPECT_EQ(among_others.velocity(ids[i]), alone.velocity(expected[i])) << "seed " << seed;
    }
  }
}

// A contact takes the place of one that has gone, and nothing of what that one held.
TEST(Independence, ABallDoesNotRollWithTheImpulseOfOneThatIsGone) {
  const auto trail = [](double height_of_other) {
    World world;
    world.add_body(ground());
    BodyDef ball = sphere({0, 0, height_of_other});
    ball.velocity = {3, 0, 0};
    ball.angular_velocity = {0, 6, 0};
    ball.material.rolling_friction = 0.1;
    const BodyId other = world.add_body(ball);
    run(world, 3);
    world.remove_body(other);
    run(world, 1);
    ball.position = {0, 9, 0.5};
    ball.velocity = {0, 1, 0};
    ball.angular_velocity = {-2, 0, 0};
    const BodyId id = world.add_body(ball);
    std::vector<double> places;
    for (int i = 0; i < 5; ++i) {
      world.step(dt);
      for (const double x : world.pose(id).position) places.push_back(x);
    }
    return places;
  };
  EXPECT_EQ(trail(0.5), trail(100));
}

// A contact's neighbours decide which kernels run, and kernels differ in writing rolling impulses. No old ones may
// stay.
TEST(Independence, ABallThatIsNoLongerHeldFromRollingHasNothingLeftOfIt) {
  const auto trail = [](bool belt) {
    World world;
    world.add_body(ground());
    BodyDef ball = sphere({0, 0, 0.5});
    ball.velocity = {3, 0, 0};
    ball.angular_velocity = {0, 6, 0};
    ball.material.rolling_friction = 0.1;
    const BodyId id = world.add_body(ball);
    BodyDef platform = static_box({100, 0, 0.5}, {5, 5, 0.5});
    if (belt) platform.surface_velocity = {1, 2, 0};
    world.add_body(platform);
    world.add_body(box({100, 0, 1.5}));
    run(world, 3);
    std::vector<double> places;
    for (const double rolling : {0.0, 0.1}) {
      world.set_material(id, {.rolling_friction = rolling});
      world.step(dt);
      for (const double x : world.angular_velocity(id)) places.push_back(x);
      const BodyHash hash = world.body_hash(id);
      places.push_back(static_cast<double>(hash.contacts >> 32));
    }
    return places;
  };
  EXPECT_EQ(trail(true), trail(false));
}

}  // namespace
}  // namespace atl::test::independence_test
