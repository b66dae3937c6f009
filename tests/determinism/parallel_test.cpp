// Same bits, always: every built-in scene has the same state hash after every step, whatever the number of threads and
// the width of the vectors. ATOLL_LONG_TESTS=1 runs the scenes at their full size, with all pairs of the two.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string>
#include <vector>

#include "support/long_tests.h"
#include "support/variants.h"
#include "support/words.h"

namespace atl::test::parallel_test {
namespace {

using divergence::Variant;

#ifdef __SANITIZE_THREAD__
constexpr int steps = 20;  // each takes up to a hundred times as long, and shares its loops as the others do
#else
constexpr int steps = 120;
#endif

/// Every kind of shape, dropped on a height field.
const std::string all_shapes = ATOLL_SOURCE_DIR "/runtime/scene/examples/shapes.json";

std::vector<std::string> scenes() {
  if (!long_tests()) {
    // The first is large enough for all workers to share.
    std::vector<std::string> small = words_of(
        "pyramid3d:layers=12 wall:base=14 islands:count=20,base=6 pile:bodies=300 rocks:bodies=200 "
        "mixed:bodies=200 drum:boxes=200 terrain:bodies=5,triangles=5000 stack:height=10 stack:height=30 "
        "stack:height=10,ratio=1000 heavy-top conveyor:boxes=4,speed=3 rolling-resistance torsion "
        "rocking-block cradle ragdolls:count=3 vehicle chain:links=20 joint-grid:n=12 bridge:planks=12 "
        "slider-crank");
    small.push_back(all_shapes);
    return small;
  }
  std::vector<std::string> full = {all_shapes};
  for (const BuiltinScene& scene : builtin_scenes()) full.push_back(scene.name);
  return full;
}

constexpr Variant one_thread{.threads = 1, .simd = Simd::Auto};

class ParallelTest : public testing::TestWithParam<std::string> {
 protected:
  Scene scene_with(const Settings& settings) const {
    Scene scene = load_scene(GetParam());
    scene.settings = settings;
    scene.steps = steps;
    return scene;
  }
};

TEST_P(ParallelTest, ThreadsAndVectorWidthDoNotChangeABit) {
  const Scene scene = scene_with({});
  const std::vector<std::uint64_t> expected = divergence::follow(scene, one_thread);
  ASSERT_NE(expected.front(), expected.back());
  expect_same(expected, scene, one_thread, one_thread);
  for (const Variant& other : variants_of({2, 1, 4})) expect_same(expected, scene, one_thread, other);
}

TEST_P(ParallelTest, NorWithAnyStabilisationAndSweepsThatEndEarly) {
  for (const Stabilisation stabilisation :
       {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    Scene scene = scene_with({.iterations = 6, .tolerance = 1e-3, .stabilisation = stabilisation, .correction = 0.3});
    const std::vector<std::uint64_t> expected = divergence::follow(scene, one_thread);
    scene.settings.profile = true;
    for (const Simd simd : simds_to_try()) expect_same(expected, scene, one_thread, {4, simd});
  }
}

TEST_P(ParallelTest, NorWithSleepingAndEveryOtherSettingTurned) {
  const Scene scene = scene_with({.substeps = 3,
                                  .iterations = 2,
                                  .relax_iterations = 2,
                                  .friction = FrictionModel::Pyramid,
                                  .warm_starting = false,
                                  .sleeping = true});
  const std::vector<std::uint64_t> expected = divergence::follow(scene, one_thread);
  for (const Simd simd : simds_to_try()) expect_same(expected, scene, one_thread, {2, simd});
}

INSTANTIATE_TEST_SUITE_P(Scenes, ParallelTest, testing::ValuesIn(scenes()), [](const auto& scene) {
  if (scene.param == all_shapes) return std::string("all_shapes");
  std::string name = scene.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

// Bullets among falling boxes: who is swept, and to where, and who is told.
TEST(Parallel, SweepsAndEventsDoNotDependOnThreads) {
  const auto run_bullets = [](const WorldDef& def) {
    World world(def);
    world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
    for (int i = 0; i < 150; ++i) {
      world.add_body(
          {.shape = Box{{0.2, 0.3, 0.25}}, .position = {0.7 * (i % 6), 0.7 * (i / 6 % 5), 0.5 + 0.6 * (i / 30)}});
      world.add_body({.shape = Sphere{0.05},
                      .position = {-20.0 - 0.37 * i, 0.02 * i, 0.3 + 0.02 * i},
                      .velocity = {150.0 + i, 0.1 * i, 1}});
    }
    for (int i = 0; i < 6; ++i) {
      world.add_body({.type = BodyType::Static,
                      .shape = Box{{0.01, 5, 5}},
                      .position = {-2.0 - i, 0, 5},
                      .continuous = true,
                      .sensor = true});
    }
    std::vector<std::uint64_t> trail;
    std::int64_t stopped = 0, passed = 0;
    for (int step = 0; step < 60; ++step) {
      stopped += world.step(1.0 / 60).counts.stopped;
      trail.push_back(world.state_hash());
      for (const ContactEvent& event : world.contact_events()) {
        trail.push_back(std::uint64_t{event.a.index} << 33 | std::uint64_t{event.b.index} << 1 | event.began);
      }
      for (const SensorEvent& event : world.sensor_events()) {
        trail.push_back(std::uint64_t{event.sensor.index} << 33 | std::uint64_t{event.body.index} << 1 | event.entered);
        ++passed;
      }
    }
    EXPECT_GT(stopped, 20);
    EXPECT_GT(passed, 100);
    return trail;
  };
  const std::vector<std::uint64_t> expected = run_bullets({.settings = {.contact_events = true}});
  for (const Variant& variant : variants_of({2, 1, 4})) {
    const Settings settings = {.contact_events = true, .simd = variant.simd};
    EXPECT_EQ(run_bullets({.threads = variant.threads, .settings = settings}), expected)
        << variant.threads << " threads on " << name_of(variant.simd);
  }
}

TEST(Simd, AutoIsOneOfTheSupportedSets) {
  const std::vector<Simd> levels = divergence::supported_simds();
  ASSERT_FALSE(levels.empty());
  const World world;
  EXPECT_NE(std::find(levels.begin(), levels.end(), world.simd()), levels.end());
}

}  // namespace
}  // namespace atl::test::parallel_test
