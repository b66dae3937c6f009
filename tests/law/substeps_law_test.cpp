// The laws that the choice of substeps rests on: errors of soft contacts and joints fall with the square of the
// substeps, and an island moves alike if substeps are chosen for it or asked for.

#include <gtest/gtest.h>

#include <string>

#include "support/scene_run.h"

namespace atl::test {
namespace {

double overlap_with(const std::string& scene, int substeps) {
  Settings settings = load_scene(scene).settings;
  settings.substeps = substeps;
  settings.contact_solver = ContactSolver::Iterative;
  SceneRun run(scene, {.settings = settings});
  test::run(run.world, 240);
  return run.penetration().p99;
}

TEST(SubstepsLaw, OverlapAtRestFallsWithTheirSquare) {
  for (const std::string scene : {"pyramid3d:layers=6", "wall:base=12", "stack:height=4"}) {
    const double eight = overlap_with(scene, 8);
    EXPECT_NEAR(eight / overlap_with(scene, 16), 4, 0.4) << scene;
  }
}

TEST(SubstepsLaw, GapsOfSweptJointsFallWithTheirSquare) {
  const auto gap_with = [](int substeps) {
    SceneRun run("joint-grid:n=10", {.settings = {.substeps = substeps, .joint_solver = JointSolver::Iterative}});
    double sum = 0;
    for (int step = 0; step < 120; ++step) {
      run.world.step(run.scene.dt);
      sum += measure_joint_drift(placed_joints(run.scene), body_states(run.world, run.ids)).rms;
    }
    return sum;
  };
  EXPECT_NEAR(gap_with(8) / gap_with(16), 4, 1);
}

// Impulses are kept by the substeps that the settings ask for: to double these is exact.
TEST(GivenSubsteps, MoveAsIfTheyWereAskedFor) {
  for (const std::string scene : {"pile:bodies=60", "wall:base=8", "ragdolls:count=3", "joint-grid:n=6", "bridge"}) {
    Settings asked = load_scene(scene).settings;
    asked.restitution_threshold = 0.1;
    Settings given = asked;
    asked.substeps = 8;
    given.substeps = 4;
    given.target = {.joint_gap = 1, .min_substeps = 8, .max_substeps = 8};
    SceneRun first(scene, {.settings = asked}), second(scene, {.settings = given});
    for (int step = 0; step < 90; ++step) {
      first.world.step(first.scene.dt);
      second.world.step(second.scene.dt);
      ASSERT_EQ(first.world.positions(), second.world.positions()) << scene << ", step " << step;
      ASSERT_EQ(first.world.orientations(), second.world.orientations()) << scene << ", step " << step;
    }
  }
}

}  // namespace
}  // namespace atl::test
