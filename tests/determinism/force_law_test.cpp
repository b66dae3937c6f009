// Steps under a force law have the same bits whatever the threads, vectors and restores, and are replayed without the
// law.

#include <atoll/forces.h>
#include <gtest/gtest.h>

#include <string>
#include <tuple>

#include "support/continued.h"
#include "support/scene_run.h"
#include "support/scenes.h"

namespace atl::test::force_law_test {
namespace {

constexpr int steps = 8;

/// A wind that swirls and drags, and grows within a step.
void blow(Forces& forces) {
  const World& world = forces.world();
  const auto velocities = world.velocities();
  forces.forces() = -3 * velocities;
  forces.forces().row(0).array() += 20 * forces.time() + world.positions().row(1).array().sin();
  forces.torques() = -0.1 * world.angular_velocities();
}

Settings settings_of(const Scene& scene, JointSolver joints, ContactSolver contacts) {
  Settings settings = scene.settings;
  settings.joint_solver = joints;
  settings.contact_solver = contacts;
  settings.contact_events = true;
  return settings;
}

using Case = std::tuple<std::string, JointSolver, ContactSolver>;

class ForceLawOn : public testing::TestWithParam<Case> {};

TEST_P(ForceLawOn, HasTheSameBitsAndIsReplayedWithoutTheLaw) {
  const Scene scene = load_scene(std::get<0>(GetParam()));
  const Settings settings = settings_of(scene, std::get<1>(GetParam()), std::get<2>(GetParam()));
  const auto fill = [&](World& world) -> MakeStep {
    fill_scene(world, scene);
    return [dt = scene.dt](World& of, int i) { i % 3 == 2 ? of.step(dt) : of.step(dt, blow); };
  };
  expect_same_bits({.fill = fill, .settings = settings, .steps = 8}, variants_of({4, 1}));
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, ForceLawOn,
    testing::Combine(testing::Values("pile:bodies=30", "ragdolls:count=2", "vehicle", "double-pendulum",
                                     "bridge:planks=6", "conveyor:boxes=6", "wall:base=5,planar=1"),
                     testing::Values(JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative),
                     testing::Values(ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative)),
    [](const auto& test) { return case_name(std::get<0>(test.param)) + "_" + std::to_string(test.index); });

// A law that asks for nothing leaves a step of as many steps of a substep each.
TEST(ForceLaw, WithoutForcesItIsAsManyShorterSteps) {
  const Scene scene = load_scene("pile:bodies=30");
  SceneRun forced(scene, {.settings = scene.settings});
  Settings single = scene.settings;
  single.substeps = 1;
  SceneRun plain(scene, {.settings = single});
  for (int i = 0; i < 40; ++i) {
    forced.world.step(scene.dt, [](Forces&) {});
    for (int k = 0; k < scene.settings.substeps; ++k) plain.world.step(scene.dt / scene.settings.substeps);
  }
  EXPECT_EQ(forced.world.positions(), plain.world.positions());
  EXPECT_EQ(forced.world.orientations(), plain.world.orientations());
  EXPECT_EQ(forced.world.velocities(), plain.world.velocities());
}

}  // namespace
}  // namespace atl::test::force_law_test
