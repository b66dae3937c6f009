// Contacts are internal forces: without gravity they change no momentum. Impulses are equal and opposite in exact
// arithmetic; what remains is the rounding of velocities in single precision, 2^-24 of a velocity an update.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "support/bodies.h"

namespace atl::test::momentum_test {
namespace {

struct Motion {
  Vector3 linear;
  Vector3 angular;  ///< about the origin
};

Motion motion(const World& world, const std::vector<BodyId>& ids, const std::vector<Vector3>& half_extents) {
  Motion sum{.linear = momentum(world, ids), .angular = Vector3::Zero()};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Pose pose = world.pose(ids[i]);
    const double mass = world.mass(ids[i]);
    const Vector3 spin = pose.orientation.conjugate() * world.angular_velocity(ids[i]);
    sum.angular += pose.position.cross(mass * world.velocity(ids[i])) +
                   pose.orientation * box_inertia(mass, half_extents[i]).cwiseProduct(spin);
  }
  return sum;
}

TEST(Momentum, SurvivesTheCollisionOfTwoTumblingBoxes) {
  World world({.gravity = Vector3::Zero()});
  const std::vector<Vector3> half_extents = {{0.5, 0.4, 0.3}, {0.3, 0.6, 0.5}};
  const double step = 1.0 / 480;
  BodyDef left = box({-2, 0.1, 0}, half_extents[0]), right = box({2, -0.2, 0.3}, half_extents[1]);
  left.velocity = {3, 0, 0.2};
  left.angular_velocity = {1, 2, -1};
  left.material.restitution = 0.3;
  right.velocity = {-2, 0.3, 0};
  right.angular_velocity = {0, -2, 1};
  const std::vector<BodyId> ids = {world.add_body(left), world.add_body(right)};
  const Motion before = motion(world, ids, half_extents);
  const double scale = world.mass(ids[0]) * left.velocity.norm() + world.mass(ids[1]) * right.velocity.norm();

  run(world, 960, step);
  const Motion after = motion(world, ids, half_extents);
  const double impulse = (world.mass(ids[0]) * (world.velocity(ids[0]) - left.velocity)).norm();
  ASSERT_GT(impulse, 0.1 * scale) << "the boxes missed each other";
  EXPECT_LT((after.linear - before.linear).norm(), 1e-6 * scale);
  // Levers are those of the step's start: they move by up to the closing speed times the step during it.
  EXPECT_LT((after.angular - before.angular).norm(), 2 * impulse * 5 * step);
}

TEST(Momentum, SurvivesACrowdThatFallsTogether) {
  World world({.gravity = Vector3::Zero()});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<BodyId> ids;
  double scale = 0;
  for (int i = 0; i < 64; ++i) {
    const Vector3 position(2.0 * (i % 4) - 3, 2.0 * (i / 4 % 4) - 3, 2.0 * (i / 16) - 3);
    BodyDef def = i % 2 ? box(position) : sphere(position);
    def.velocity = -position + Vector3(uniform(random), uniform(random), uniform(random));
    def.density = 1000 * std::exp(2 * uniform(random));
    def.material.restitution = i % 3 ? 0 : 0.5;
    ids.push_back(world.add_body(def));
    scale += world.mass(ids.back()) * def.velocity.norm();
  }
  const Vector3 before = momentum(world, ids);
  std::int64_t max = 0;
  for (int i = 0; i < 300; ++i) max = std::max(max, world.step(dt).counts.contacts);
  ASSERT_GT(max, 50);
  // Some ten updates a body and substep at random: 2^-24 sqrt(300 * 4 * 10).
  EXPECT_LT((momentum(world, ids) - before).norm(), 6.6e-6 * scale);
}

TEST(Momentum, DraggedSlabTakesWhatTheBoxOnItLoses) {
  // On ice: the box slides along the slab until friction has made them one.
  World world;
  world.add_body(ground(0));
  BodyDef slab = box({0, 0, 0.5}, {4, 1, 0.5});
  BodyDef rider = box({-2, 0, 1.5});
  rider.velocity = {3, 0, 0};
  const std::vector<BodyId> ids = {world.add_body(slab), world.add_body(rider)};
  const double total = world.mass(ids[1]) * rider.velocity.x();
  run(world, 120);
  const double common = total / (world.mass(ids[0]) + world.mass(ids[1]));
  EXPECT_NEAR(momentum(world, ids).x(), total, 1e-5 * total);
  EXPECT_NEAR(world.velocity(ids[0]).x(), common, 1e-3 * common);
  EXPECT_NEAR(world.velocity(ids[1]).x(), common, 1e-3 * common);
}

}  // namespace
}  // namespace atl::test::momentum_test
