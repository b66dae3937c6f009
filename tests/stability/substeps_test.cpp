// More substeps are never worse, whatever an island's solver is and whatever decides it.

#include <gtest/gtest.h>

#include "support/scene_run.h"
#include "support/scenes.h"

namespace atl::test {
namespace {

struct Errors {
  double penetration = 0, sink = 0, drift = 0;  ///< m
};

Errors errors_after(const char* scene, int substeps, int steps) {
  SceneRun run(scene, {.settings = {.substeps = substeps}});
  for (int i = 0; i < steps; ++i) run.world.step(run.scene.dt);
  const RestReport rest = run.rest();
  return {run.penetration().max, rest.sink_max, rest.drift_max};
}

struct Case {
  const char* scene;
  int steps;
};

class SubstepsTest : public testing::TestWithParam<Case> {};

// By more than rounding, and for what drifts at random by more than a tenth.
TEST_P(SubstepsTest, NeverMakeItWorse) {
  constexpr double rounding = 2e-5;  // m
  Errors before = {1e9, 1e9, 1e9};
  for (const int substeps : {2, 4, 8, 16, 32}) {
    const Errors now = errors_after(GetParam().scene, substeps, GetParam().steps);
    EXPECT_LE(now.penetration, before.penetration + rounding) << substeps;
    EXPECT_LE(now.sink, before.sink + rounding) << substeps;
    EXPECT_LE(now.drift, 1.1 * before.drift + rounding) << substeps;
    before = now;
  }
}

// The second and third wall are between where none and where all are given finer substeps.
INSTANTIATE_TEST_SUITE_P(Scenes, SubstepsTest,
                         testing::Values(Case{"wall:base=30", 200}, Case{"wall:base=60", 100},
                                         Case{"wall:base=70", 100}, Case{"stack:height=4", 300},
                                         Case{"stack:height=7", 300}, Case{"stack:height=20", 300},
                                         Case{"stack:height=10,ratio=100", 300}, Case{"pyramid3d:layers=9", 200},
                                         Case{"islands:count=3", 200}),
                         [](const auto& param) { return case_name(param.param.scene); });

}  // namespace
}  // namespace atl::test
