// Scenes that start in their ideal rest pose stay there. A soft contact under n boxes of mass m gives way by about
// n g / (omega^2 share) whatever the scene does, so sink is bounded apart from drift and tilt, which have no excuse.

#include <gtest/gtest.h>

#include "support/scene_run.h"

namespace atl::test {
namespace {

TEST(Rest, PyramidStandsWithLittlePenetration) {
  SceneRun pyramid("pyramid3d:layers=6");
  run_finite(pyramid.world, 300);
  EXPECT_LT(pyramid.penetration().max, 2e-3);
  const RestReport rest = pyramid.rest();
  EXPECT_LT(rest.sink_max, 1e-2);
  EXPECT_LT(rest.drift_max, 1e-2);
  EXPECT_LT(rest.tilt_max, 1e-2);
}

TEST(Rest, StackOfTenStandsForTenSeconds) {
  SceneRun stack("stack:height=10");
  run_finite(stack.world, 600);
  const RestReport rest = stack.rest();
  EXPECT_LT(rest.sink_max, 5e-2);
  EXPECT_LT(rest.drift_max, 1e-2);
  EXPECT_LT(rest.tilt_max, 1e-2);
  EXPECT_LT(kinetic_energy(stack.world, dynamic_bodies(stack.world, stack.ids)), 1e-3);
}

TEST(Rest, WallStands) {
  SceneRun wall("wall:base=20");
  run_finite(wall.world, 300);
  EXPECT_LT(wall.penetration().max, 5e-3);
  const RestReport rest = wall.rest();
  EXPECT_LT(rest.sink_max, 0.1);
  EXPECT_LT(rest.drift_max, 0.05);
  EXPECT_LT(rest.tilt_max, 0.05);
}

TEST(Rest, IslandsStand) {
  SceneRun islands("islands:count=20,base=6");
  run_finite(islands.world, 300);
  EXPECT_LT(islands.penetration().max, 2e-3);
  EXPECT_LT(islands.rest().drift_max, 1e-2);
  EXPECT_LT(islands.rest().tilt_max, 1e-2);
}

TEST(Rest, SphereStaysWhereItWasPutOnTopOfABox) {
  // An unstable balance, but an exact one: nothing in it points sideways.
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  const BodyId ball = world.add_body(sphere({0, 0, 2}));
  run_finite(world, 180);
  EXPECT_NEAR(world.pose(ball).position.z(), 1.5, 5e-3);
  EXPECT_LT(world.pose(ball).position.head<2>().norm(), 1e-3);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.5, 2e-3);
}

TEST(Rest, BoxBridgesTwoStaticBoxes) {
  World world;
  world.add_body(static_box({-1, 0, 0.5}, {0.5, 1, 0.5}));
  world.add_body(static_box({1, 0, 0.5}, {0.5, 1, 0.5}));
  const BodyId beam = world.add_body(box({0, 0, 1.5}, {1.4, 0.3, 0.2}));
  run_finite(world, 180);
  EXPECT_NEAR(world.pose(beam).position.z(), 1.2, 1e-3);
  EXPECT_LT(tilt(world, beam), 1e-3);
}

TEST(Rest, StaticBoxStopsWhatSlidesIntoIt) {
  World world;
  world.add_body(ground());
  world.add_body(static_box({3, 0, 0.5}, {0.5, 2, 0.5}));
  BodyDef def = box({0, 0, 0.5});
  def.velocity = {6, 0, 0};
  const BodyId crate = world.add_body(def);
  double furthest = 0;
  for (int i = 0; i < 120; ++i) {
    world.step(dt);
    furthest = std::max(furthest, world.pose(crate).position.x());
  }
  EXPECT_NEAR(furthest, 2, 1e-2);
  EXPECT_LT(world.velocity(crate).norm(), 1e-3);
}

TEST(Rest, StackOfBouncyBoxesComesToRest) {
  for (const double gap : {0.0, 1e-5, 1e-3}) {
    World world;
    world.add_body(ground());
    std::vector<BodyId> ids;
    for (int i = 0; i < 6; ++i) {
      BodyDef def = box({0, 0, 0.5 + i * (1 + gap)});
      def.material.restitution = 0.8;
      ids.push_back(world.add_body(def));
    }
    run_finite(world, 200);
    for (int i = 0; i < 60; ++i) {
      world.step(dt);
      ASSERT_LT(kinetic_energy(world, ids), 1e-6) << gap << ", step " << i;
    }
    EXPECT_NEAR(world.pose(ids.back()).position.z(), 5.5, 2e-2) << gap;
  }
}

}  // namespace
}  // namespace atl::test
