// FCL makes a pair's first manifold; from then on the pair is followed without it. An answer that the separation along
// its own axis refutes is replaced, which a stand-in for FCL would be each time.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace atl {
namespace {

class FclFirstManifold : public testing::TestWithParam<const char*> {};

TEST_P(FclFirstManifold, StandsAndIsFollowed) {
  const Scene scene = load_scene(GetParam());
  World world({.gravity = scene.gravity});
  build_scene(scene, world);
  std::int64_t calls = 0, repairs = 0, recomputed = 0;
  const auto run = [&](int steps) {
    calls = repairs = recomputed = 0;
    for (int i = 0; i < steps; ++i) {
      const StepCounts counts = world.step(scene.dt).counts;
      calls += counts.fcl_calls;
      repairs += counts.fcl_repairs;
      recomputed += counts.recomputed_manifolds;
    }
  };
  run(120);
  EXPECT_GT(calls, 100);
  EXPECT_GT(recomputed, 5 * calls);
  EXPECT_LT(repairs, calls / 8) << calls;
}

INSTANTIATE_TEST_SUITE_P(Scenes, FclFirstManifold,
                         testing::Values("pile:bodies=300", "rocks:bodies=300", "mixed:bodies=300",
                                         "marbles:bodies=3000"),
                         [](const auto& scene) {
                           return std::string(scene.param).substr(0, std::string(scene.param).find(':'));
                         });

}  // namespace
}  // namespace atl
