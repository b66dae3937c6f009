// A sphere launched sliding on a plane without spin (a bowling ball): friction brakes it and spins it up until it
// rolls. Its angular momentum about the contact point is constant, so it rolls at 5/7 of its speed, from
// t = 2 v0 / (7 mu g) on, and keeps that speed.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/bodies.h"

namespace atl::test::rolling_test {
namespace {

constexpr double radius = 0.5;
constexpr double speed = 7;
constexpr double friction = 0.3;
constexpr double rolling_time = 2 * speed / (7 * friction * g);

/// Friction follows the normal force by up to a substep; the centre's height, the lever of friction, is off by the
/// depth of the soft contact, well below 1e-4 of the radius.
constexpr double lever_error = 1e-4;

struct Bowl {
  World world;
  BodyId ball;
  Vector3 forward;

  explicit Bowl(double heading) : forward(std::cos(heading), std::sin(heading), 0) {
    world.add_body(ground(friction));
    BodyDef def = sphere({0, 0, radius}, radius);
    def.velocity = speed * forward;
    def.material.friction = friction;
    ball = world.add_body(def);
  }
  /// Velocity of the sphere's lowest point.
  Vector3 slip() const { return world.velocity(ball) + world.angular_velocity(ball).cross(Vector3(0, 0, -radius)); }
};

TEST(Rolling, SlidingSphereSlowsDownByMuGUntilItRolls) {
  Bowl bowl(0);
  int i = 0;
  const double lag = 1.5 * substep();
  for (; (i + 1) * dt < rolling_time - lag; ++i) {
    bowl.world.step(dt);
    const double t = (i + 1) * dt;
    EXPECT_NEAR(bowl.world.velocity(bowl.ball).x(), speed - friction * g * t, friction * g * lag);
    EXPECT_NEAR(bowl.slip().x(), speed - 3.5 * friction * g * t, 3.5 * friction * g * lag);
  }
  for (; (i - 1) * dt < rolling_time + lag; ++i) bowl.world.step(dt);
  EXPECT_LT(bowl.slip().norm(), 1e-4 * speed);
}

TEST(Rolling, RollsAtFiveSeventhsOfItsSpeedInEveryDirection) {
  for (int i = 0; i < 12; ++i) {
    Bowl bowl(i * std::numbers::pi / 6);
    run(bowl.world, 60);
    const Vector3 velocity = bowl.world.velocity(bowl.ball);
    EXPECT_LT((velocity - 5.0 / 7 * speed * bowl.forward).norm(), lever_error * speed) << 30 * i;
    EXPECT_LT(bowl.slip().norm(), 1e-4 * speed) << 30 * i;
  }
}

TEST(Rolling, KeepsRolling) {
  Bowl bowl(0.3);
  run(bowl.world, 60);
  const Vector3 start = bowl.world.pose(bowl.ball).position;
  const Vector3 velocity = bowl.world.velocity(bowl.ball);
  run(bowl.world, 300);
  EXPECT_LT((bowl.world.velocity(bowl.ball) - velocity).norm(), 1e-4 * speed);
  const Vector3 moved = bowl.world.pose(bowl.ball).position - start;
  EXPECT_LT((moved - velocity * 300 * dt).norm(), 1e-4 * moved.norm());
}

TEST(Rolling, DownASlopeWithFiveSeventhsOfTheFreeAcceleration) {
  const double angle = 0.2;  // friction needed: 2/7 tan a = 0.06
  World world({.gravity = g * Vector3(std::sin(angle), 0, -std::cos(angle))});
  world.add_body(ground(friction));
  BodyDef def = sphere({0, 0, radius}, radius);
  def.material.friction = friction;
  const BodyId ball = world.add_body(def);
  run(world, 120);
  const double expected = 5.0 / 7 * g * std::sin(angle) * 2;
  EXPECT_NEAR(world.velocity(ball).x(), expected, g * std::sin(angle) * substep() + lever_error * expected);
}

}  // namespace
}  // namespace atl::test::rolling_test
