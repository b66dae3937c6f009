// Going over a world's bodies and joints, and what spares users frames and velocities by hand.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <numbers>
#include <unordered_set>

#include "support/random.h"

namespace atl {
namespace {

using test::Random;

Pose random_pose(Random& random) {
  return {Vector3(random.real(-2, 2), random.real(-2, 2), random.real(-2, 2)), random.rotation()};
}

TEST(WorldHandles, BodiesAndJointsAreListedWhileTheyAreThere) {
  World world;
  const BodyId a = world.add_body({.position = {0, 0, 0}});
  const BodyId b = world.add_body({.position = {3, 0, 0}});
  const BodyId c = world.add_body({.position = {6, 0, 0}});
  const JointId ab = world.add_joint(joint_at(world, BallJoint{}, a, b, {1.5, 0, 0}));
  const JointId bc = world.add_joint(joint_at(world, BallJoint{}, b, c, {4.5, 0, 0}));
  EXPECT_EQ(world.bodies(), (std::vector{a, b, c}));
  EXPECT_EQ(world.joints(), (std::vector{ab, bc}));
  world.remove_body(a);
  EXPECT_EQ(world.bodies(), (std::vector{b, c}));
  EXPECT_EQ(world.joints(), (std::vector{bc}));
  const BodyId again = world.add_body({.position = {0, 0, 0}});
  EXPECT_EQ(world.bodies(), (std::vector{again, b, c})) << "the index was used again";
  const std::unordered_set<BodyId> bodies = {a, again, b, c, again};
  EXPECT_EQ(bodies.size(), 4u);
  EXPECT_EQ((std::unordered_set<JointId>{ab, bc, bc}.size()), 2u);
}

// Whatever the poses, the turn and the centre of mass: it is there after the step, to rounding.
TEST(WorldHandles, AKinematicBodyIsMovedToAPose) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    World world({.gravity = Vector3::Zero()});
    const Pose start = random_pose(random), end = random_pose(random);
    const BodyId id = world.add_body({.type = BodyType::Kinematic,
                                      .shape = i % 2 == 0 ? Shape(Box{{0.5, 0.2, 0.1}}) : Shape(Cone{0.5, 1}),
                                      .position = start.position,
                                      .orientation = start.orientation});
    world.move_to(id, end, 0.02);
    world.step(0.02);
    EXPECT_LT((world.pose(id).position - end.position).norm(), 1e-12);
    EXPECT_LT(world.pose(id).orientation.angularDistance(end.orientation), 1e-7);
    world.move_to(id, end, 0.02);
    EXPECT_LT(world.angular_velocity(id).norm(), 1e-10);
  }
}

TEST(WorldHandles, WhatIsMovedToCarries) {
  World world;
  const BodyId table = world.add_body({.type = BodyType::Kinematic, .shape = Box{{2, 2, 0.1}}});
  const BodyId crate = world.add_body({.shape = Box{{0.2, 0.2, 0.2}}, .position = {0, 0, 0.3}});
  constexpr double dt = 1.0 / 60;
  for (int i = 1; i <= 60; ++i) {
    const double t = i * dt;
    world.move_to(table, {{0.5 * t * t, 0, 0}, Quaternion::Identity()}, dt);
    world.step(dt);
  }
  EXPECT_NEAR(world.pose(crate).position.x(), world.pose(table).position.x(), 2e-3);
}

TEST(WorldHandles, AJointAtAPointStartsAtZero) {
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    World world({.gravity = Vector3::Zero()});
    const auto add = [&] {
      const Pose pose = random_pose(random);
      return world.add_body({.shape = Box{{0.1, 0.2, 0.3}},
                             .position = pose.position,
                             .orientation = pose.orientation,
                             .angular_velocity = random.direction()});
    };
    const BodyId a = add(), b = add();
    const Vector3 point = Vector3(random.real(-3, 3), 0, 1);
    const Vector3 axis = i % 3 == 0 ? Vector3(Vector3::Unit(i % 9 / 3)) : Vector3(3 * random.direction());
    const JointId hinge = world.add_joint(joint_at(world, HingeJoint{}, a, b, point, axis));
    EXPECT_NEAR(world.joint_state(hinge).position[0], 0, 1e-7);
    const JointDef& def = world.joint(hinge);
    for (const auto& [id, frame] : {std::pair(a, def.frame_first), std::pair(b, def.frame_second)}) {
      const Pose pose = world.pose(id);
      EXPECT_LT((pose.position + pose.orientation * frame.position - point).norm(), 1e-12);
      EXPECT_LT((pose.orientation * (frame.orientation * Vector3::UnitX()) - axis.normalized()).norm(), 1e-12);
    }
  }
  World world;
  const BodyId a = world.add_body({}), b = world.add_body({.position = {5, 0, 0}});
  EXPECT_TRUE(joint_at(world, HingeJoint{}, a, b, {0, 0, 0}).frame_first.orientation.isApprox(Quaternion::Identity()));
  EXPECT_THROW(joint_at(world, HingeJoint{}, a, b, {0, 0, 0}, Vector3::Zero()), Error);
  EXPECT_THROW(joint_at(world, HingeJoint{}, a, {}, {0, 0, 0}), Error);
}

TEST(WorldHandles, ContactForcesOfOneBodyAreThoseThatHoldIt) {
  World world;
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{{0, 0, 1}}});
  const BodyId lower = world.add_body({.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, 0.5}});
  const BodyId upper = world.add_body({.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, 1.5}});
  for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
  const auto sum_of = [&](BodyId id) {
    double sum = 0;
    for (const ContactForce& force : world.contact_forces(id))
      sum += (force.b == id ? 1 : -1) * force.normal.z() * force.normal_force;
    return sum;
  };
  EXPECT_NEAR(sum_of(upper), 9.81 * world.mass(upper), 1e-2 * 9.81 * world.mass(upper));
  EXPECT_NEAR(sum_of(lower), 9.81 * world.mass(lower), 2e-2 * 9.81 * world.mass(lower));
  EXPECT_EQ(world.contact_forces(upper).size() + 4, world.contact_forces(lower).size());
  world.remove_body(upper);
  EXPECT_THROW(world.contact_forces(upper), Error);
}

TEST(WorldHandles, MoveToRefusesWhatItCantMove) {
  World world;
  const BodyId crate = world.add_body({});
  const BodyId lift = world.add_body({.type = BodyType::Kinematic, .position = {5, 0, 0}});
  EXPECT_THROW(world.move_to(crate, {}, 0.01), Error);
  EXPECT_THROW(world.move_to(lift, {}, 0), Error);
  EXPECT_THROW(world.move_to(lift, {{NAN, 0, 0}, Quaternion::Identity()}, 0.01), Error);
  EXPECT_EQ(world.velocity(lift), Vector3::Zero());
}

}  // namespace
}  // namespace atl
