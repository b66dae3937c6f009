// A leg with a servo that is told to stretch jumps off the ground, as high as the energy of the servo takes it.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/bodies.h"

namespace atl::test::jumping_leg_test {
namespace {

constexpr double body_mass = 1, foot_mass = 0.2;     // kg
constexpr double stiffness = 2000, stretch = 0.05;   // N/m, m
constexpr double all_mass = body_mass + foot_mass;   // kg
constexpr double hangs = foot_mass * g / stiffness;  // m, by which the servo is stretched as it lifts the foot
constexpr double way = stretch + hangs;              // m, of the body until then

// m, of the centre of mass. The servo's energy, k (stretch^2 - hangs^2) / 2, lifts the body and makes it move; as the
// foot leaves the ground, that takes its part of the momentum.
double height() {
  const double square = stiffness * (stretch * stretch - hangs * hangs) / body_mass - 2 * g * way;
  const double speed = body_mass * std::sqrt(square) / all_mass;
  return body_mass * way / all_mass + speed * speed / (2 * g);
}

double height_at(double step) {
  World world;
  world.add_body(ground());
  const BodyId foot = world.add_body({.shape = Box{{0.1, 0.1, 0.02}}, .position = {0, 0, 0.02}, .mass = foot_mass});
  const BodyId body =
      world.add_body({.shape = Box{Vector3::Constant(0.05)}, .position = {0, 0, 0.3}, .mass = body_mass});
  SliderJoint leg;
  leg.offset.motor = JointMotor{.max_force = 1e5, .servo = JointServo{.target = stretch, .stiffness = stiffness}};
  world.add_joint(joint_at(world, leg, foot, body, {0, 0, 0.2}, Vector3::UnitZ()));
  world.set_collision_enabled(foot, body, false);
  const auto centre = [&] {
    return (body_mass * world.pose(body).position.z() + foot_mass * world.pose(foot).position.z()) / all_mass;
  };
  const double start = centre();
  double max = 0;
  for (int i = 0; i * step < 0.5; ++i) {
    world.step(step);
    max = std::max(max, centre() - start);
  }
  return max;
}

// Standing on the ground, it moves to first order in the step.
TEST(JumpingLeg, ComesAsHighAsItsServoTakesIt) {
  EXPECT_NEAR(height_at(1.0 / 60) / height(), 1, 0.03);
  EXPECT_NEAR(height_at(1.0 / 240) / height(), 1, 0.01);
  EXPECT_NEAR(height_at(1.0 / 960) / height(), 1, 0.003);
}

}  // namespace
}  // namespace atl::test::jumping_leg_test
