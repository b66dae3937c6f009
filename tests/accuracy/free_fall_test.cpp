// Parabolas under any gravity, and beside bodies that touch. The integrator meets them exactly: what is left is the
// rounding of a few hundred double additions, below 1e-13 of the largest term. Spin and steps of any length are those
// of analytic_scene_test.cpp.

#include <gtest/gtest.h>

#include "support/bodies.h"

namespace atl::test::free_fall_test {
namespace {

constexpr int steps = 300;
constexpr double duration = steps * dt;
constexpr double rounding = 1e-12;  ///< relative to the distance travelled

const Vector3 start(1, -2, 50);
const Vector3 launch(3, -4, 12);

Vector3 ballistic(const Vector3& acceleration, double t) { return start + launch * t + 0.5 * acceleration * t * t; }

void expect_ballistic(const World& world, BodyId id, const Vector3& acceleration, double t) {
  const double distance = launch.norm() * t + 0.5 * acceleration.norm() * t * t;
  EXPECT_LT((world.pose(id).position - ballistic(acceleration, t)).norm(), rounding * distance);
  EXPECT_LT((world.velocity(id) - launch - acceleration * t).norm(),
            rounding * (launch.norm() + acceleration.norm() * t));
}

TEST(FreeFall, GravityAndItsScaleActAlongAnyDirection) {
  for (const double scale : {0.0, 2.0, -1.0}) {
    World world({.gravity = {1, 2, -3}});
    const BodyId id =
        world.add_body({.shape = Box{{0.5, 0.2, 0.3}}, .position = start, .velocity = launch, .gravity_scale = scale});
    run(world, steps);
    expect_ballistic(world, id, scale * Vector3(1, 2, -3), duration);
  }
}

TEST(FreeFall, NeighboursInContactDoNotDisturbIt) {
  World world;
  world.add_body(ground());
  add_stack(world, 3, {20, 20, 0});
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .position = start, .velocity = launch});
  run(world, 120);
  expect_ballistic(world, id, world.gravity(), 120 * dt);
}

}  // namespace
}  // namespace atl::test::free_fall_test
