// Rolling friction rho pulls at a ball as if the normal force acted rho ahead of the contact: a ball that rolls without
// slipping slows down by rho g / (7/5 r), and one on a slope stays while tan a <= rho / r.

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"

namespace atl::test::rolling_friction_test {
namespace {

constexpr double radius = 0.5;
constexpr double friction = 0.6;

struct Ball {
  World world;
  BodyId id;

  Ball(double angle, double ground_resistance, double ball_resistance, double speed = 0, const Settings& settings = {})
      : world({.gravity = g * Vector3(std::sin(angle), 0, -std::cos(angle)), .settings = settings}) {
    BodyDef plane = ground(friction);
    plane.material.rolling_friction = ground_resistance;
    world.add_body(plane);
    BodyDef def = sphere({0, 0, radius}, radius);
    def.material = {.friction = friction, .rolling_friction = ball_resistance};
    def.velocity = {speed, 0, 0};
    def.angular_velocity = {0, speed / radius, 0};
    id = world.add_body(def);
  }
  double x() const { return world.pose(id).position.x(); }
  double speed() const { return world.velocity(id).x(); }
};

TEST(RollingFriction, StopsABallAfterTheClosedFormsPath) {
  constexpr double resistance = 0.05, speed = 2;
  constexpr double deceleration = resistance * g / radius / 1.4;
  constexpr double path = speed * speed / (2 * deceleration);
  for (const Stabilisation stabilisation :
       {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    for (const bool warm : {true, false}) {
      Ball ball(0, 0, resistance, speed, {.warm_starting = warm, .stabilisation = stabilisation});
      run(ball.world, 240);
      EXPECT_NEAR(ball.x(), path, 5e-3 * path) << static_cast<int>(stabilisation) << (warm ? " warm" : " cold");
      EXPECT_LT(std::abs(ball.speed()), 1e-4);
    }
  }
}

TEST(RollingFriction, OfAPairIsTheLargerOfTheTwo) {
  const auto stopped_at = [](double of_ground, double of_ball) {
    Ball ball(0, of_ground, of_ball, 2);
    run(ball.world, 240);
    return ball.x();
  };
  EXPECT_EQ(stopped_at(0.05, 0), stopped_at(0, 0.05));
  EXPECT_EQ(stopped_at(0.05, 0.03), stopped_at(0.05, 0.05));
  EXPECT_GT(stopped_at(0, 0.04), 1.1 * stopped_at(0, 0.05));
}

TEST(RollingFriction, HoldsABallOnASlopeThatIsShallowEnough) {
  constexpr double angle = 0.1;
  const double enough = radius * std::tan(angle);
  Ball held(angle, 0, 1.05 * enough);
  run(held.world, 300);
  EXPECT_LT(std::abs(held.x()), 1e-3);
  EXPECT_LT(std::abs(held.speed()), 1e-4);

  for (const double share : {0.0, 0.5, 0.95}) {
    Ball rolling(angle, 0, share * enough);
    run(rolling.world, 120);
    // Along the slope: m r (g sin a) - rho m g cos a turns 7/5 m r^2.
    const double expected = 5.0 / 7 * (1 - share) * g * std::sin(angle) * 2;
    EXPECT_NEAR(rolling.speed(), expected, 1e-2 * g * std::sin(angle)) << share;
  }
}

TEST(RollingFriction, BetweenTwoBallsMovesMomentumBetweenThemOnly) {
  // Pressed together by their speeds, spinning oppositely. Without friction, so that nothing moves their centres aside.
  World world({.gravity = Vector3::Zero()});
  std::vector<BodyId> ids;
  for (const double side : {-1.0, 1.0}) {
    BodyDef def = sphere({side * 0.5, 0, 0});
    def.material = {.friction = 0, .rolling_friction = 0.2};
    def.velocity = {-side * 2, 0, 0};
    def.angular_velocity = {0, side * 3, 1};
    ids.push_back(world.add_body(def));
  }
  const auto angular_momentum = [&] {
    Vector3 sum = Vector3::Zero();
    for (const BodyId id : ids) {
      const double mass = world.mass(id);
      sum += mass * world.pose(id).position.cross(world.velocity(id)) + 0.4 * mass * 0.25 * world.angular_velocity(id);
    }
    return sum;
  };
  const Vector3 before = momentum(world, ids), spin_before = angular_momentum();
  const double scale = 0.4 * world.mass(ids[0]) * 0.25 * 3;
  const Vector3 relative_spin = world.angular_velocity(ids[1]) - world.angular_velocity(ids[0]);
  run(world, 10);
  EXPECT_LT((momentum(world, ids) - before).norm(), 1e-5 * world.mass(ids[0]) * 2);
  EXPECT_LT((angular_momentum() - spin_before).norm(), 1e-4 * scale);
  EXPECT_LT((world.angular_velocity(ids[1]) - world.angular_velocity(ids[0])).norm(), 0.9 * relative_spin.norm());
}

}  // namespace
}  // namespace atl::test::rolling_friction_test
