// Newton's law of restitution: the speed of parting is e times the speed of approach.
//
// The speed of approach is that of the impact, wherever within a step it falls, so a ball returns to e^2 of its height
// but for single-precision arithmetic. It leaves the surface at the end of a step, up to dt late.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/bodies.h"

namespace atl::test::restitution_test {
namespace {

constexpr double height = 2;  ///< m, the drop
constexpr double radius = 0.5;
const double impact = std::sqrt(2 * g * height);

BodyDef ball(const Vector3& position, double restitution) {
  BodyDef def = sphere(position, radius);
  def.material.restitution = restitution;
  return def;
}

/// Height of the ball's lowest point at the top of its first rebound.
double apex(double restitution, double step) {
  World world;
  world.add_body(ground());
  const BodyId id = world.add_body(ball({0, 0, height + radius}, restitution));
  bool rebounds = false;
  double highest = 0;
  for (double t = 0; t < 2; t += step) {
    world.step(step);
    const double up = world.velocity(id).z();
    rebounds = rebounds || up > 0.1;
    if (rebounds) highest = std::max(highest, world.pose(id).position.z() - radius);
    if (rebounds && up < 0) break;
  }
  return highest;
}

TEST(Restitution, BallReturnsToESquaredOfItsHeight) {
  for (const double e : {0.5, 0.8, 1.0}) {
    for (const double step : {1.0 / 60, 1.0 / 480}) {
      // Heights are seen at the ends of steps only, up to half a step from the top.
      const double sampling = g * step * step / 8;
      EXPECT_NEAR(apex(e, step), e * e * height, sampling + 1e-4 * height) << "e " << e << ", dt " << step;
    }
  }
}

TEST(Restitution, BallWithoutItStaysDown) {
  World world;
  world.add_body(ground());
  const BodyId id = world.add_body(ball({0, 0, height + radius}, 0));
  run(world, static_cast<int>(std::sqrt(2 * height / g) / dt) + 2);
  for (int i = 0; i < 120; ++i) {
    world.step(dt);
    ASSERT_LT(std::abs(world.velocity(id).z()), 1e-2);
    ASSERT_NEAR(world.pose(id).position.z(), radius, 1e-3);
  }
}

TEST(Restitution, ImpactBelowTheThresholdDoesNotBounce) {
  for (const double threshold : {1.0, 10.0}) {
    World world({.settings = {.restitution_threshold = threshold}});
    world.add_body(ground());
    const BodyId id = world.add_body(ball({0, 0, height + radius}, 1));
    double fastest = 0;
    for (int i = 0; i < 60; ++i) {
      world.step(dt);
      fastest = std::max(fastest, world.velocity(id).z());
    }
    EXPECT_EQ(fastest > 1, threshold < impact) << threshold;
  }
}

// By how fast gravity makes things fall in a substep, so that a world a thousand times as large bounces alike if
// gravity is.
TEST(Restitution, WhatBouncesDoesNotDependOnTheScale) {
  std::vector<double> heights;
  for (const double scale : {1e-2, 1.0, 1e3}) {
    World world({.gravity = {0, 0, -g * scale}});
    BodyDef floor = ground();
    floor.material.restitution = 0.5;
    world.add_body(floor);
    BodyDef falls = sphere({0, 0, 1.1 * scale}, 0.1 * scale);
    falls.material = {.restitution = 0.5};
    const BodyId id = world.add_body(falls);
    for (int i = 0; i < 90; ++i) {
      world.step(dt);
      heights.push_back(world.pose(id).position.z() / scale);
    }
  }
  for (std::size_t i = 0; i < 90; ++i) {
    EXPECT_NEAR(heights[i], heights[90 + i], 2e-3) << i;
    EXPECT_NEAR(heights[180 + i], heights[90 + i], 2e-3) << i;
  }
}

TEST(Restitution, ElasticBallKeepsItsEnergyOverManyBounces) {
  World world;
  world.add_body(ground());
  const BodyId id = world.add_body(ball({0, 0, height + radius}, 1));
  for (int i = 0; i < 1200; ++i) {
    world.step(dt);
    const double drop = world.pose(id).position.z() - radius;
    const double energy = g * drop + 0.5 * world.velocity(id).squaredNorm();
    ASSERT_NEAR(energy, g * height, 5e-4 * g * height) << "step " << i;
  }
}

TEST(Restitution, EqualSpheresSwapTheirVelocities) {
  World world({.gravity = Vector3::Zero()});
  BodyDef left = ball({-2, 0, 0}, 1), right = ball({2, 0, 0}, 1);
  left.velocity = {5, 0, 0};
  right.velocity = {-3, 0, 0};
  const BodyId a = world.add_body(left), b = world.add_body(right);
  run(world, 60);
  // A handful of single-precision operations on speeds of 8 m/s.
  EXPECT_LT((world.velocity(a) - right.velocity).norm(), 1e-5);
  EXPECT_LT((world.velocity(b) - left.velocity).norm(), 1e-5);
}

TEST(Restitution, UnequalSpheresPartByNewtonsLaw) {
  World world({.gravity = Vector3::Zero()});
  const double m1 = 1, m2 = 3, u1 = 4, u2 = -1, e = 0.5;
  BodyDef left = ball({-2, 0, 0}, e), right = ball({2, 0, 0}, 0);  // the larger of the two counts
  left.mass = m1;
  left.velocity = {u1, 0, 0};
  right.mass = m2;
  right.velocity = {u2, 0, 0};
  const BodyId a = world.add_body(left), b = world.add_body(right);
  run(world, 120);
  const double common = (m1 * u1 + m2 * u2) / (m1 + m2);
  EXPECT_NEAR(world.velocity(a).x(), common + m2 * e * (u2 - u1) / (m1 + m2), 1e-5);
  EXPECT_NEAR(world.velocity(b).x(), common + m1 * e * (u1 - u2) / (m1 + m2), 1e-5);
}

TEST(Restitution, BoxesThatMeetFaceToFaceBounceWithoutTurning) {
  World world({.gravity = Vector3::Zero()});
  BodyDef left = box({-2, 0, 0}), right = box({2, 0, 0});
  left.material.restitution = 1;
  left.velocity = {5, 0, 0};
  const BodyId a = world.add_body(left), b = world.add_body(right);
  run(world, 60);
  EXPECT_LT(world.velocity(a).norm(), 1e-3);
  EXPECT_LT((world.velocity(b) - left.velocity).norm(), 1e-3);
  EXPECT_LT(world.angular_velocity(a).norm() + world.angular_velocity(b).norm(), 1e-3);
}

TEST(Restitution, SpheresThatMissEachOtherKeepTheirVelocities) {
  for (const double clearance : {1e-3, 0.05}) {
    World world({.gravity = Vector3::Zero()});
    BodyDef left = ball({-3.03, 0, 0}, 1), right = ball({0, 2 * radius + clearance, 0}, 1);
    left.velocity = {20, 0, 0};
    const BodyId a = world.add_body(left), b = world.add_body(right);
    run(world, 30);
    EXPECT_EQ(world.velocity(a), left.velocity) << clearance;
    EXPECT_TRUE(world.velocity(b).isZero(0)) << clearance;
  }
}

}  // namespace
}  // namespace atl::test::restitution_test
