// Same bits, always: every built-in scene has the same state hash after every step, whatever the number of threads and
// the width of the vectors. ATOLL_LONG_TESTS=1 runs the scenes at their full size.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

constexpr int steps = 120;

bool long_tests() {
  const char* value = std::getenv("ATOLL_LONG_TESTS");
  return value != nullptr && std::string_view(value) == "1";
}

std::vector<std::string> scenes() {
  if (!long_tests()) {
    return {"pyramid3d:layers=6", "wall:base=14", "islands:count=20,base=6", "pile:bodies=300", "stack:height=10"};
  }
  std::vector<std::string> full;
  for (const BuiltinScene& scene : builtin_scenes()) full.push_back(scene.name);
  return full;
}

const char* simd_name(Simd simd) {
  switch (simd) {
    case Simd::Auto:
      return "auto";
    case Simd::Portable:
      return "portable";
    case Simd::Sse4:
      return "sse4";
    case Simd::Avx2:
      return "avx2";
    case Simd::Avx512:
      return "avx512";
    case Simd::Neon:
      return "neon";
  }
  return "?";
}

/// The instruction sets that a World can be made with on this machine.
std::vector<Simd> supported() {
  std::vector<Simd> levels;
  for (const Simd simd : {Simd::Portable, Simd::Sse4, Simd::Avx2, Simd::Avx512, Simd::Neon}) {
    try {
      const World world({.settings = {.simd = simd}});
      EXPECT_EQ(world.simd(), simd);
      levels.push_back(simd);
    } catch (const Error&) {
    }
  }
  return levels;
}

std::vector<std::uint64_t> hashes(const Scene& scene, const WorldDef& def) {
  SceneRun run(scene, def);
  std::vector<std::uint64_t> hashes = {run.world.state_hash()};
  for (int i = 0; i < steps; ++i) {
    run.world.step(scene.dt);
    hashes.push_back(run.world.state_hash());
  }
  return hashes;
}

/// The first step after which two runs differ.
std::optional<std::size_t> first_difference(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i]) return i;
  }
  return std::nullopt;
}

class ParallelTest : public testing::TestWithParam<std::string> {
 protected:
  const Scene scene_ = load_scene(GetParam());

  void expect_same(const std::vector<std::uint64_t>& expected, const WorldDef& def) {
    const auto difference = first_difference(expected, hashes(scene_, def));
    EXPECT_FALSE(difference.has_value()) << "diverges in step " << *difference << " with " << def.threads
                                         << " threads on " << simd_name(def.settings.simd);
  }
};

TEST_P(ParallelTest, ThreadsAndVectorWidthDoNotChangeABit) {
  const std::vector<std::uint64_t> expected = hashes(scene_, {});
  ASSERT_NE(expected.front(), expected.back());
  expect_same(expected, {});
  for (const Simd simd : supported()) {
    for (const int threads : {1, 2, 4}) expect_same(expected, {.threads = threads, .settings = {.simd = simd}});
  }
}

TEST_P(ParallelTest, NorWithSleepingAndEveryOtherSettingTurned) {
  Settings settings = {.substeps = 3,
                       .iterations = 2,
                       .relax_iterations = 2,
                       .friction = FrictionModel::Pyramid,
                       .warm_starting = false,
                       .sleeping = true};
  const std::vector<std::uint64_t> expected = hashes(scene_, {.settings = settings});
  for (const Simd simd : supported()) {
    settings.simd = simd;
    expect_same(expected, {.threads = 2, .settings = settings});
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ParallelTest, testing::ValuesIn(scenes()),
                         [](const auto& scene) { return scene.param.substr(0, scene.param.find(':')); });

TEST(Simd, AutoIsOneOfTheSupportedSets) {
  const std::vector<Simd> levels = supported();
  ASSERT_FALSE(levels.empty());
  const World world;
  EXPECT_NE(std::find(levels.begin(), levels.end(), world.simd()), levels.end());
}

}  // namespace
}  // namespace atl::test
