// Work that a step skips because nothing changed must not show: islands kept from the step before, and idle contacts of
// sleepers.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "support/scene_run.h"

namespace atl::test::kept_work_test {
namespace {

void add_static_and_remove_it(World& world) { world.remove_body(world.add_body(static_box({0, 0, -1000}, {1, 1, 1}))); }

// A body that comes and goes far off makes a world build its islands anew in each step.
TEST(KeptWork, IslandsAreWhatTheyWouldBeIfMadeAnew) {
  SceneRun keeps("islands:count=6,base=5");
  SceneRun rebuilds("islands:count=6,base=5");
  std::vector<World*> worlds = {&keeps.world, &rebuilds.world};
  for (World* world : worlds) add_static_and_remove_it(*world);
  std::size_t islands_seen = 0;
  std::int64_t last = -1;
  for (int i = 0; i < 240; ++i) {
    if (i == 60) {  // knocks a wall over, which parts it and joins it to others
      for (World* world : worlds) {
        BodyDef def = sphere({0, -4, 2});
        def.density = 5000;
        def.velocity = {0, 30, 0};
        world->add_body(def);
      }
    }
    add_static_and_remove_it(rebuilds.world);
    const StepReport report = keeps.world.step(dt);
    rebuilds.world.step(dt);
    islands_seen += report.counts.islands != last;
    last = report.counts.islands;
    ASSERT_EQ(keeps.world.positions().leftCols(91), rebuilds.world.positions().leftCols(91)) << "step " << i;
    ASSERT_EQ(keeps.world.angular_velocities().leftCols(91), rebuilds.world.angular_velocities().leftCols(91));
  }
  EXPECT_GT(islands_seen, 2u) << "they change now and then";
}

// Stacks that fall asleep, and are woken by wakes, impulses, removals, a body that falls on one and one that is driven
// into another.
std::vector<std::uint64_t> run_sleepers(int threads) {
  World world({.threads = threads, .settings = {.sleeping = true, .contact_events = true}});
  world.add_body(ground());
  std::vector<std::vector<BodyId>> stacks;
  for (int i = 0; i < 60; ++i) stacks.push_back(add_stack(world, 3, {2.5 * (i % 10), 2.5 * (i / 10), 0}));
  BodyDef def = box({-2, 0, 1}, {0.2, 0.2, 0.2});
  def.type = BodyType::Kinematic;
  const BodyId ram = world.add_body(def);
  std::vector<std::uint64_t> hashes;
  std::int64_t max_asleep = 0;
  for (int i = 0; i < 300; ++i) {
    if (i == 80) world.add_body(sphere({5, 5, 8}));
    if (i == 90) world.wake(stacks[13][2]);
    if (i == 100) world.apply_impulse(stacks[33][2], {0, 2000, 0}, world.pose(stacks[33][2]).position);
    if (i == 110) world.remove_body(stacks[44][0]);
    if (i == 120) world.set_velocity(ram, {2, 0, 0}, Vector3::Zero());
    if (i == 240) world.set_velocity(ram, Vector3::Zero(), Vector3::Zero());
    max_asleep = std::max(max_asleep, world.step(dt).counts.asleep);
    hashes.push_back(world.state_hash());
  }
  EXPECT_GT(max_asleep, 150);
  return hashes;
}

TEST(KeptWork, SleepersAreTheSameOnAnyNumberOfThreads) {
  const std::vector<std::uint64_t> expected = run_sleepers(1);
  for (const int threads : {2, 3}) EXPECT_EQ(run_sleepers(threads), expected) << threads;
}

}  // namespace
}  // namespace atl::test::kept_work_test
