// Damping v' = -c v against v0 exp(-c t). A step of first order, v / (1 + c h), decays by exp(-c t (1 - c h / 2 +
// ...)), so after t the relative error is at most c^2 h t / 2 to leading order, h being the substep.

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"

namespace atl::test::damping_test {
namespace {

constexpr double damping = 0.5;
constexpr int steps = 120;
constexpr double duration = steps * dt;

double relative_error() { return damping * damping * substep() * duration / 2; }

TEST(Damping, VelocityDecaysExponentially) {
  World world({.gravity = Vector3::Zero()});
  const Vector3 launch(6, -2, 3);
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .velocity = launch, .linear_damping = damping});
  run(world, steps);

  const Vector3 velocity = launch * std::exp(-damping * duration);
  EXPECT_LT((world.velocity(id) - velocity).norm(), relative_error() * velocity.norm());
  // The integral over the decay; the velocity's error at the end bounds its error before.
  const Vector3 path = launch * (1 - std::exp(-damping * duration)) / damping;
  EXPECT_LT((world.pose(id).position - path).norm(), (relative_error() + damping * substep()) * path.norm());
}

TEST(Damping, SpinDecaysExponentially) {
  World world({.gravity = Vector3::Zero()});
  const Vector3 spin(1, 2, -3);
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .angular_velocity = spin, .angular_damping = damping});
  run(world, steps);
  const Vector3 expected = spin * std::exp(-damping * duration);
  EXPECT_LT((world.angular_velocity(id) - expected).norm(), relative_error() * expected.norm());
}

TEST(Damping, FallReachesTerminalVelocity) {
  World world;
  const double strong = 4;
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .linear_damping = strong});
  run(world, 600);
  const double terminal = -g / strong;
  EXPECT_NEAR(world.velocity(id).z(), terminal, strong * substep() * std::abs(terminal));
}

TEST(Damping, LeavesTheOtherKindOfMotionAlone) {
  World world({.gravity = Vector3::Zero()});
  const Vector3 velocity(1, 2, 3), spin(3, 2, 1);
  const BodyId slowed =
      world.add_body({.shape = Sphere{0.5}, .velocity = velocity, .angular_velocity = spin, .linear_damping = damping});
  const BodyId unspun = world.add_body({.shape = Sphere{0.5},
                                        .position = {0, 50, 0},
                                        .velocity = velocity,
                                        .angular_velocity = spin,
                                        .angular_damping = damping});
  run(world, steps);
  EXPECT_EQ(world.angular_velocity(slowed), spin);
  EXPECT_EQ(world.velocity(unspun), velocity);
}

}  // namespace
}  // namespace atl::test::damping_test
