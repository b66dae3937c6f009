// Contact forces at rest are statics: every interface carries the weight above it.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/bodies.h"

namespace atl::test::contact_force_test {
namespace {

constexpr double share = 0.005;  ///< of the force expected: what a stack still moves after two seconds
constexpr int settle = 120;

TEST(ContactForces, EveryInterfaceOfAStackCarriesTheWeightAbove) {
  World world;
  const BodyId plane = world.add_body(ground());
  const std::vector<BodyId> stack = add_stack(world, 5);
  run(world, settle);

  const double weight = world.mass(stack[0]) * g;
  BodyId below = plane;
  for (std::size_t i = 0; i < stack.size(); ++i) {
    const double load = static_cast<double>(stack.size() - i) * weight;
    const Vector3 force = contact_force(world, below, stack[i]);
    EXPECT_NEAR(force.z(), load, share * load) << "under box " << i;
    EXPECT_LT(Vector3(force.x(), force.y(), 0).norm(), share * load) << "under box " << i;
    below = stack[i];
  }
}

TEST(ContactForces, AddUpToTheWeightAtTwoSupportsByTheLever) {
  // A beam whose centre is 1 m from one support and 3 m from the other rests on them as 3 : 1.
  World world;
  const BodyId left = world.add_body({.type = BodyType::Static, .shape = Sphere{0.5}, .position = {-1, 0, 0.5}});
  const BodyId right = world.add_body({.type = BodyType::Static, .shape = Sphere{0.5}, .position = {3, 0, 0.5}});
  const BodyId beam = world.add_body(box({0, 0, 1.25}, {4, 0.5, 0.25}));
  run(world, settle);
  const double weight = world.mass(beam) * g;
  EXPECT_NEAR(contact_force(world, left, beam).z(), 0.75 * weight, share * weight);
  EXPECT_NEAR(contact_force(world, right, beam).z(), 0.25 * weight, share * weight);
}

TEST(ContactForces, ForceFromAboveAddsToTheWeight) {
  World world;
  const BodyId plane = world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  const Vector3 push(2000, 0, -5000);  // sideways below the friction that holds
  for (int i = 0; i < settle; ++i) {
    world.apply_force(crate, push);
    world.step(dt);
  }
  const Vector3 load = push + world.mass(crate) * world.gravity();
  EXPECT_LT((contact_force(world, plane, crate) + load).norm(), share * load.norm());
}

TEST(ContactForces, RestingBoxTouchesWithItsFourCorners) {
  World world;
  const BodyId plane = world.add_body(ground());
  const BodyId crate = world.add_body(box({3, 2, 0.5}));
  const StepReport report = run(world, settle);
  EXPECT_EQ(report.counts.contacts, 1);
  EXPECT_EQ(report.counts.points, 4);

  const auto points = world.contact_forces();
  ASSERT_EQ(points.size(), 4u);
  Vector3 sum = Vector3::Zero();
  for (const ContactForce& point : points) {
    EXPECT_EQ(point.a == plane ? point.b : point.a, crate);
    EXPECT_GT(point.normal_force, 0);
    EXPECT_NEAR(std::abs(point.normal.z()), 1, 1e-6);
    const Vector3 arm = point.position - Vector3(3, 2, 0);
    EXPECT_NEAR(std::abs(arm.x()), 0.5, 1e-3);
    EXPECT_NEAR(std::abs(arm.y()), 0.5, 1e-3);
    EXPECT_NEAR(arm.z(), 0, 1e-3);
    sum += arm;
  }
  EXPECT_LT(Vector3(sum.x(), sum.y(), 0).norm(), 1e-3) << "each corner once";
}

TEST(ContactForces, NormalPointsFromAToB) {
  World world;
  const BodyId low = world.add_body(static_box({0, 0, 0}, {2, 2, 0.5}));
  const BodyId high = world.add_body(box({0, 0, 1}));
  run(world, 10);
  ASSERT_FALSE(world.contact_forces().empty());
  for (const ContactForce& point : world.contact_forces()) {
    const Vector3 from_a_to_b = world.pose(point.b).position - world.pose(point.a).position;
    EXPECT_GT(point.normal.dot(from_a_to_b), 0);
    EXPECT_NEAR(point.normal.norm(), 1, 1e-6);
    EXPECT_TRUE((point.a == low && point.b == high) || (point.a == high && point.b == low));
  }
}

TEST(ContactForces, NoneInFreeFallAndNoneAfterParting) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  world.add_body(sphere({5, 0, 20}));
  run(world, 10);
  EXPECT_EQ(world.contact_forces().size(), 4u);
  world.set_pose(crate, {.position = {0, 0, 10}});
  world.step(dt);
  EXPECT_TRUE(world.contact_forces().empty());
}

}  // namespace
}  // namespace atl::test::contact_force_test
