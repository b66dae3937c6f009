// Bodies that start inside one another part gently and stay finite.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

/// Largest relative speed while two bodies that overlap push each other apart without gravity.
double parting_speed(World& world, BodyId a, BodyId b, int steps) {
  double fastest = 0;
  for (int i = 0; i < steps; ++i) {
    EXPECT_EQ(world.step(dt).first_quarantined, -1);
    fastest = std::max(fastest, (world.velocity(b) - world.velocity(a)).norm());
  }
  return fastest;
}

TEST(Overlap, BoxesAQuarterDeepPartNoFasterThanThePushSpeed) {
  for (const double push : {0.5, 3.0}) {
    World world({.gravity = Vector3::Zero(), .settings = {.contact_push_speed = push}});
    const BodyId a = world.add_body(box({0, 0, 0}));
    const BodyId b = world.add_body(box({0.75, 0.1, -0.05}));
    EXPECT_LT(parting_speed(world, a, b, 240), 1.1 * push);
    EXPECT_LT(overlap(placed(world, a, Box{}), placed(world, b, Box{})), 1e-3);
    EXPECT_LT((world.pose(a).position + world.pose(b).position - Vector3(0.75, 0.1, -0.05)).norm(), 1e-3)
        << "they part symmetrically";
  }
}

TEST(Overlap, StackAQuarterDeepDoesNotBurst) {
  World world;
  world.add_body(ground());
  std::vector<BodyId> ids;
  for (int i = 0; i < 4; ++i) ids.push_back(world.add_body(box({0, 0, 0.5 + 0.75 * i})));
  double highest = 0;
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(world.step(dt).first_quarantined, -1);
    highest = std::max(highest, world.pose(ids.back()).position.z());
  }
  // Every contact of the column adds at most the push speed, and a body thrown up at speed v rises by v^2 / 2g.
  const double push = 4 * world.settings().contact_push_speed;
  EXPECT_LT(highest, 3.5 + push * push / (2 * g));
  for (std::size_t i = 0; i + 1 < ids.size(); ++i) {
    EXPECT_LT(overlap(placed(world, ids[i], Box{}), placed(world, ids[i + 1], Box{})), 5e-3);
  }
}

TEST(Overlap, BoxBelowTheGroundComesUp) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.2}));
  run_finite(world, 300);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.5, 2e-3);
}

TEST(Overlap, CoincidentBodiesPart) {
  const std::vector<Shape> shapes = {Sphere{0.5}, Box{}, Box{{0.5, 0.3, 0.2}}};
  for (const Shape& first : shapes) {
    for (const Shape& second : shapes) {
      World world({.gravity = Vector3::Zero()});
      const BodyId a = world.add_body({.shape = first, .position = {1, 2, 3}});
      const BodyId b = world.add_body({.shape = second, .position = {1, 2, 3}});
      EXPECT_LT(parting_speed(world, a, b, 300), 1.1 * world.settings().contact_push_speed);
      EXPECT_LT(overlap(placed(world, a, first), placed(world, b, second)), 1e-2)
          << first.index() << " and " << second.index();
    }
  }
}

TEST(Overlap, SphereWithItsCentreOnAFaceOrInsideABoxLeavesIt) {
  for (const Vector3& centre : {Vector3(0.5, 0, 0), Vector3(0.3, 0.1, 0), Vector3(0.5, 0.5, 0.5)}) {
    World world({.gravity = Vector3::Zero()});
    const BodyId block = world.add_body(static_box({0, 0, 0}, {0.5, 0.5, 0.5}));
    const BodyId ball = world.add_body(sphere(centre, 0.25));
    run_finite(world, 300);
    EXPECT_LT(overlap(placed(world, block, Box{}), placed(world, ball, Sphere{0.25})), 1e-3) << centre.transpose();
    EXPECT_GT(world.pose(ball).position.x(), 0.5);
  }
}

}  // namespace
}  // namespace atl::test
