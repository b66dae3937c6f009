// A recording is replayed with the same hash after every step, whatever the threads and vectors, from wherever in a run
// it began.

#include <gtest/gtest.h>

#include <string>

#include "support/scene_run.h"
#include "support/scenes.h"
#include "support/temporary_file.h"
#include "support/variants.h"

namespace atl::test::replay_test {
namespace {

constexpr int steps = 12;

/// With all that a state can have, whose recording begins after some steps.
std::uint64_t record(const std::string& text, int steps_before, const std::filesystem::path& path) {
  Settings settings = load_scene(text).settings;
  settings.sleeping = true;
  settings.time_to_sleep = 0.1;
  settings.contact_events = true;
  SceneRun run(text, {.threads = 2, .settings = settings});
  for (int step = -steps_before; step < steps; ++step) {
    if (step == 0) run.world.record(path);
    apply_forces(run.scene, run.world, run.ids);
    run.world.step(run.scene.dt);
  }
  const std::uint64_t hash = run.world.state_hash();
  run.world.stop_recording();
  return hash;
}

class ReplayOfScene : public testing::TestWithParam<std::string> {};

TEST_P(ReplayOfScene, IsTheSameOnAnyMachine) {
  const TemporaryFile file("." + case_name(GetParam()));
  for (const int steps_before : {0, 20}) {
    const std::uint64_t hash = record(GetParam(), steps_before, file.path());
    for (const divergence::Variant& variant : variants_of({4, 1})) {
      const ReplayResult result = replay(file.path(), {.threads = variant.threads, .simd = variant.simd});
      ASSERT_FALSE(result.divergence.has_value())
          << "step " << result.divergence->step << ", " << variant.threads << " threads";
      EXPECT_EQ(result.steps, steps);
      EXPECT_EQ(result.hash, hash);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Small, ReplayOfScene, testing::ValuesIn(small_scenes()),
                         [](const auto& test) { return case_name(test.param); });

}  // namespace
}  // namespace atl::test::replay_test
