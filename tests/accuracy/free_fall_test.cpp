// Free flight has closed forms that the integrator meets exactly: what is left is the rounding of a few hundred
// double additions, below 1e-13 of the largest term.

#include <gtest/gtest.h>

#include <cmath>

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

TEST(FreeFall, PositionAndVelocityFollowTheParabola) {
  World world;
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .position = start, .velocity = launch});
  for (int i = 1; i <= steps; ++i) {
    world.step(dt);
    expect_ballistic(world, id, world.gravity(), i * dt);
  }
}

TEST(FreeFall, ParabolaDoesNotDependOnTheStep) {
  for (const double step : {1.0 / 7, 1.0 / 60, 1.0 / 1000}) {
    World world;
    const BodyId id = world.add_body({.shape = Sphere{0.5}, .position = start, .velocity = launch});
    const int count = static_cast<int>(std::lround(2 / step));
    run(world, count, step);
    expect_ballistic(world, id, world.gravity(), count * step);
  }
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

TEST(FreeFall, SphereSpinsAtAConstantRate) {
  const Vector3 spin(0.7, -1.1, 2.3);
  const Quaternion tilted(Eigen::AngleAxisd(0.4, Vector3(1, 1, 1).normalized()));
  World world;
  const BodyId id =
      world.add_body({.shape = Sphere{0.5}, .position = start, .orientation = tilted, .angular_velocity = spin});
  run(world, steps);
  const Quaternion expected = Quaternion(Eigen::AngleAxisd(spin.norm() * duration, spin.normalized())) * tilted;
  EXPECT_LT(world.pose(id).orientation.angularDistance(expected), rounding * spin.norm() * duration);
  EXPECT_LT((world.angular_velocity(id) - spin).norm(), rounding * spin.norm());
}

TEST(FreeFall, OrientationStaysAUnitQuaternion) {
  World world;
  const BodyId id = world.add_body({.shape = Box{{0.5, 0.2, 0.3}}, .angular_velocity = {3, 5, 7}});
  run(world, 1000);
  EXPECT_NEAR(world.pose(id).orientation.norm(), 1, 1e-15 * 4);
}

}  // namespace
}  // namespace atl::test::free_fall_test
