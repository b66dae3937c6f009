// Bodies that start at rest stay there. Stacks, walls and pyramids are cases of runtime/checks/stability.

#include <gtest/gtest.h>

#include "support/scene_run.h"

namespace atl::test {
namespace {

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
