// Divergence of two recordings.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <functional>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "support/temporary_file.h"

namespace atl::test {
namespace {

// Five boxes that tumble about, over so many steps, with something done ahead of each.
void record(const TemporaryFile& file, std::int64_t steps, const WorldDef& def,
            const std::function<void(World&, std::int64_t step)>& ahead = {}) {
  World world(def);
  world.record(file.path());
  world.add_body(ground());
  for (int i = 0; i < 5; ++i) {
    world.add_body({.shape = Box{{0.3, 0.4, 0.5}}, .position = {0.2 * i, 0.1 * i, 1 + 1.2 * i}, .name = "box"});
  }
  for (std::int64_t step = 1; step <= steps; ++step) {
    if (ahead) ahead(world, step);
    world.step(dt);
  }
  world.stop_recording();
}

// One bit of one number, in the middle of a long run.
TEST(FirstDifference, AFlippedBitIsFoundInItsStepAndBody) {
  constexpr std::int64_t steps = 10000, flipped = 4321;
  const TemporaryFile plain(".a.recording"), other(".b.recording");
  record(plain, steps, {});
  record(other, steps, {}, [&](World& world, std::int64_t step) {
    if (step != flipped) return;
    const BodyId body = world.bodies()[3];
    Vector3 velocity = world.velocity(body);
    velocity.x() = std::bit_cast<double>(std::bit_cast<std::uint64_t>(velocity.x()) ^ 1);
    world.set_velocity(body, velocity, world.angular_velocity(body));
  });
  const FirstDifferenceResult found = find_first_difference(plain.path(), other.path());
  EXPECT_EQ(found.steps, steps);
  EXPECT_LE(found.replays, 14);
  ASSERT_TRUE(found.difference.has_value());
  EXPECT_EQ(found.difference->step, flipped);
  EXPECT_TRUE(found.difference->by_calls);
  ASSERT_EQ(found.difference->bodies.size(), 1u);
  EXPECT_EQ(found.difference->bodies.front().id.index, 3u);
  // How far it may move within its bounds follows from that.
  EXPECT_EQ(found.difference->bodies.front().parts, (std::vector<std::string>{"velocity", "bounds"}));
}

// Settings are no body's, and change what a step comes to only once there is something to solve.
TEST(FirstDifference, OtherSettingsShowInTheSolve) {
  const TemporaryFile plain(".a.recording"), other(".b.recording");
  const Settings swept = {.contact_solver = ContactSolver::Iterative};
  record(plain, 100, {.settings = swept});
  record(other, 100, {.settings = swept}, [&](World& world, std::int64_t step) {
    Settings more = swept;
    more.iterations = 3;
    if (step == 50) world.set_settings(more);
  });
  const FirstDifferenceResult found = find_first_difference(plain.path(), other.path());
  ASSERT_TRUE(found.difference.has_value());
  EXPECT_EQ(found.difference->step, 50);
  EXPECT_TRUE(found.difference->by_calls);
  EXPECT_GE(found.difference->bodies_step, 50);
  EXPECT_EQ(found.difference->phase, Phase::SolveIslands);
  EXPECT_FALSE(found.difference->bodies.empty());
}

// The recordings differ in something outside the state's hash, here another contact modifier.
TEST(FirstDifference, PhasesAreToldOfWhatAStepDoes) {
  const TemporaryFile plain(".a.recording"), other(".b.recording");
  const auto with = [](double friction) {
    return [friction](World& world, std::int64_t step) {
      if (step != 1) return;
      world.set_contact_modifier([friction](ModifiableContact& contact) { contact.friction = friction; });
    };
  };
  record(plain, 200, {}, with(0.5));
  record(other, 200, {}, with(0.4));
  const FirstDifferenceResult found = find_first_difference(plain.path(), other.path(), {.threads = 2});
  ASSERT_TRUE(found.difference.has_value());
  EXPECT_FALSE(found.difference->by_calls);
  EXPECT_EQ(found.difference->phase, Phase::SolveIslands);
  EXPECT_FALSE(found.difference->bodies.empty());
}

TEST(FirstDifference, ThereIsNoneOfThreadsAndInstructionSets) {
  const TemporaryFile plain(".a.recording"), other(".b.recording");
  record(plain, 60, {});
  record(other, 80, {.threads = 2, .settings = {.simd = Simd::Portable}});
  const FirstDifferenceResult found = find_first_difference(plain.path(), other.path());
  EXPECT_FALSE(found.difference.has_value());
  EXPECT_EQ(found.steps, 60);
  EXPECT_EQ(found.replays, 0);
  expect_error([&] { find_first_difference(plain.path(), "/nowhere"); }, {"replay: /nowhere: "});
}

}  // namespace
}  // namespace atl::test
