// Newton's law of restitution: the speed of parting is e times the speed of approach.
// Bounces of one ball on the ground are held against their closed form in analytic_scene_test.cpp.

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
