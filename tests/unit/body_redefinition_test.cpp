// A body that becomes another under its id, by a definition, and bodies that are disabled for a while.

#include <atoll/atoll.h>
#include <atoll/queries.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

constexpr double short_step = 1.0 / 240;

void run_short(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(short_step);
}

template <typename Change>
void change_definition(World& world, BodyId id, const Change& change) {
  BodyDef def = world.definition(id);
  change(def);
  world.set_definition(id, def);
}

TEST(BodyRedefinition, AStaticBodyThatBecomesDynamicFallsAndOneThatBecomesStaticStays) {
  World world;
  const BodyId body = world.add_body({.type = BodyType::Static, .shape = Box{}, .position = {0, 0, 10}});
  const BodyId rider = world.add_body({.shape = Sphere{0.25}, .position = {0, 0, 10.75}});
  run_short(world, 60);
  EXPECT_NEAR(world.pose(rider).position.z(), 10.75, 2e-3);
  change_definition(world, body, [](BodyDef& def) { def.type = BodyType::Dynamic, def.density = 500; });
  EXPECT_EQ(world.type(body), BodyType::Dynamic);
  EXPECT_NEAR(world.mass(body), 500, 1e-9);
  run_short(world, 240);
  EXPECT_NEAR(world.pose(body).position.z(), 10 - 9.81 / 2, 9.81 * short_step);
  change_definition(world, body, [](BodyDef& def) { def.type = BodyType::Static; });
  EXPECT_EQ(world.velocity(body), Vector3::Zero());
  EXPECT_EQ(world.mass(body), std::numeric_limits<double>::infinity());
  const Pose pose = world.pose(body);
  run_short(world, 480);
  EXPECT_EQ(world.pose(body).position, pose.position);
  EXPECT_NEAR(world.pose(rider).position.z(), pose.position.z() + 0.75, 2e-3) << "it still carries what lies on it";
}

TEST(BodyRedefinition, OneThatSleepsMayBecomeAnythingElse) {
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic, BodyType::Dynamic}) {
    World world({.settings = {.sleeping = true}});
    world.add_body(ground());
    const BodyId body = world.add_body({.shape = Box{}, .position = {0, 0, 0.5}, .awake = false});
    ASSERT_FALSE(world.definition(body).awake);
    change_definition(world, body, [](BodyDef& def) { def.user_data = 1; });
    EXPECT_TRUE(world.is_asleep(body));
    change_definition(world, body, [&](BodyDef& def) {
      def.type = type;
      def.may_sleep = false;
    });
    EXPECT_EQ(world.type(body), type);
    run_short(world, 240);
    EXPECT_FALSE(world.is_asleep(body));
    EXPECT_NEAR(world.pose(body).position.z(), 0.5, 2e-3);
  }
}

TEST(BodyRedefinition, AKinematicBodyGoesOnAsItMovedAndPushes) {
  World world({.gravity = Vector3::Zero()});
  const BodyId body = world.add_body({.shape = Box{}, .velocity = {2, 0, 0}});
  const BodyId heavy = world.add_body({.shape = Box{}, .position = {2, 0, 0}, .mass = 1e6});
  change_definition(world, body, [](BodyDef& def) { def.type = BodyType::Kinematic; });
  run_short(world, 480);
  EXPECT_NEAR(world.pose(body).position.x(), 4, 1e-9);
  EXPECT_GT(world.pose(heavy).position.x(), 4.99);
}

TEST(BodyRedefinition, ASensorLetsBodiesInAndASolidKeepsThemOut) {
  World world;
  const BodyId floor = world.add_body({.type = BodyType::Static, .shape = Box{{2, 2, 0.5}}});
  const BodyId ball = world.add_body({.shape = Sphere{0.25}, .position = {0, 0, 0.75}});
  run_short(world, 120);
  ASSERT_NEAR(world.pose(ball).position.z(), 0.75, 2e-3);
  change_definition(world, floor, [](BodyDef& def) { def.sensor = true; });
  run_short(world, 24);
  EXPECT_NEAR(world.pose(ball).position.z(), 0.75 - 9.81 / 2 * 0.01, 5e-3);
  EXPECT_EQ(world.bodies_in(floor).size(), 1u);
}

TEST(BodyRedefinition, InertiaCentreOfMassAndLocksAreTheNewOnes) {
  World world({.gravity = Vector3::Zero()});
  const BodyId body = world.add_body({.shape = Box{}, .angular_velocity = {0, 0, 3}, .mass = 2});
  change_definition(world, body, [](BodyDef& def) {
    def.inertia = Matrix3(Vector3(4, 5, 6).asDiagonal());
    def.centre_of_mass = {0.5, 0, 0};
  });
  EXPECT_TRUE(world.centre_of_mass(body).isApprox(Vector3(0.5, 0, 0)));
  EXPECT_TRUE(world.velocity(body).isApprox(Vector3(0, 1.5, 0))) << "of the point where the centre is now";
  change_definition(world, body, [](BodyDef& def) { def.velocity = def.angular_velocity = Vector3::Zero(); });
  world.apply_impulse(body, {0, 12, 0}, {1.5, 0, 0});
  EXPECT_TRUE(world.angular_velocity(body).isApprox(Vector3(0, 0, 2)));
  change_definition(world, body, [](BodyDef& def) { def.locks.angular = {false, false, true}; });
  EXPECT_EQ(world.angular_velocity(body), Vector3::Zero());
  EXPECT_TRUE(world.velocity(body).isApprox(Vector3(0, 6, 0)));
}

// A stack at rest is not disturbed: contacts keep their impulses where nothing that they go by changes.
TEST(BodyRedefinition, WhatADefinitionSaysAgainChangesNothing) {
  World world, other;
  for (World* of : {&world, &other}) {
    of->add_body(ground());
    for (int i = 0; i < 4; ++i) of->add_body(box({0, 0, 0.5 + i}));
    run_short(*of, 60);
  }
  for (const BodyId id : world.bodies()) world.set_definition(id, world.definition(id));
  EXPECT_EQ(world.state_hash(), other.state_hash());
  change_definition(world, world.bodies()[2], [](BodyDef& def) { def.material.friction = 0.1; });
  double apart = 0;
  for (int i = 0; i < 10; ++i) {
    run_short(world, 1);
    apart = std::max(apart, world.velocity(world.bodies()[4]).norm());
  }
  EXPECT_LT(apart, 1e-3) << "contacts were not found anew, without their impulses";
}

// The hull that the body had goes, and its memory is used again.
TEST(BodyRedefinition, ItsShapeMayBeAnEqualOneElsewhereInMemory) {
  const auto tetrahedron = [](double size) {
    const Vector3 corners[] = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
    return ConvexHull(corners);
  };
  World world;
  const BodyId id = world.add_body({.shape = tetrahedron(1)});
  for (const Axis axis : {Axis::X, Axis::Z}) {
    change_definition(world, id, [&](BodyDef& def) {
      def.shape = tetrahedron(1);
      def.locks = MotionLocks::plane(axis);
    });
  }
  std::vector<ConvexHull> others;
  for (int i = 0; i < 20; ++i) others.push_back(tetrahedron(3));
  EXPECT_TRUE(world.bounds(id).upper.isApprox(Vector3::Ones()));
}

TEST(BodyRedefinition, AJointIsIdleWhileNeitherOfItsBodiesIsDynamic) {
  World world({.gravity = {0, 0, -10}});
  const BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
  const BodyId bob = world.add_body({.shape = Sphere{0.2}, .position = {0, 0, -2}, .mass = 3});
  const JointId joint = world.add_joint(joint_at(world, BallJoint{}, post, bob, {0, 0, -0.5}));
  const auto force = [&] {
    run_short(world, 60);
    return world.joint_state(joint).force.z();
  };
  EXPECT_NEAR(force(), 30, 0.03);
  change_definition(world, bob, [](BodyDef& def) { def.type = BodyType::Static; });
  EXPECT_EQ(force(), 0);
  EXPECT_EQ(world.step(short_step).counts.joints, 0);
  change_definition(world, bob, [](BodyDef& def) {
    def.type = BodyType::Dynamic;
    def.mass = 3;
  });
  EXPECT_NEAR(force(), 30, 0.03);
  EXPECT_LT((world.pose(bob).position - Vector3(0, 0, -2)).norm(), 1e-3);
}

TEST(BodyRedefinition, ADefinitionThatCannotBeChangesNothing) {
  World world;
  const BodyId wall = world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  const BodyId arm = world.add_body(box({0, 0, 2}));
  world.add_joint(joint_at(world, HingeJoint{}, wall, arm, {0, 0, 3}));
  const std::uint64_t hash = world.state_hash();
  const auto refuse = [&](BodyId id, const auto& change) { EXPECT_THROW(change_definition(world, id, change), Error); };
  refuse(wall, [](BodyDef& def) { def.type = BodyType::Dynamic; });
  refuse(arm, [](BodyDef& def) { def.position.x() = std::numeric_limits<double>::infinity(); });
  refuse(arm, [](BodyDef& def) { def.material.friction = -1; });
  EXPECT_EQ(world.state_hash(), hash);
}

TEST(EnabledBodies, ADisabledFloorIsNotThereUntilItIsBack) {
  World world({.settings = {.sleeping = true}});
  const BodyId floor = world.add_body({.type = BodyType::Static, .shape = Box{{2, 2, 0.5}}});
  const BodyId ball = world.add_body({.shape = Sphere{0.25}, .position = {0, 0, 0.75}});
  run_short(world, 480);
  ASSERT_TRUE(world.is_asleep(ball));
  world.set_enabled(floor, false);
  EXPECT_FALSE(world.is_enabled(floor));
  EXPECT_FALSE(world.is_asleep(ball));
  EXPECT_FALSE(Queries(world).is_blocked({.origin = {1, 1, 5}, .direction = {0, 0, -1}, .max_distance = 10}));
  EXPECT_TRUE(world.quarantined().empty());
  const double start = world.pose(ball).position.z();
  run_short(world, 240);
  EXPECT_NEAR(world.pose(ball).position.z(), start - 9.81 / 2, 9.81 * short_step);
  world.set_enabled(floor, true);
  world.set_pose(ball, {{0, 0, 1}});
  world.set_velocity(ball, Vector3::Zero(), Vector3::Zero());
  run_short(world, 480);
  EXPECT_NEAR(world.pose(ball).position.z(), 0.75, 2e-3);
  EXPECT_TRUE(Queries(world).is_blocked({.origin = {1, 1, 5}, .direction = {0, 0, -1}, .max_distance = 10}));
}

TEST(EnabledBodies, JointsIdleAndTheBodyGoesOnAsItMoved) {
  World world({.gravity = {0, 0, -10}});
  const BodyId post = world.add_body({.shape = Box{}, .velocity = {0, 0, 1}, .gravity_scale = 0});
  const BodyId bob = world.add_body({.shape = Sphere{0.2}, .position = {0, 0, -2}, .velocity = {0, 0, 1}});
  const JointId joint = world.add_joint(joint_at(world, BallJoint{}, post, bob, {0, 0, -0.5}));
  world.set_enabled(post, false);
  world.apply_force(post, {1e6, 0, 0});
  run_short(world, 60);
  EXPECT_EQ(world.pose(post).position, Vector3::Zero());
  EXPECT_NEAR(world.velocity(bob).z(), 1 - 10 * 0.25, 1e-9) << "in free fall";
  EXPECT_EQ(world.joint_state(joint).force, Vector3::Zero());
  world.set_pose(bob, {{0, 0, -2}});
  world.set_velocity(bob, {0, 0, 1}, Vector3::Zero());
  world.set_enabled(post, true);
  EXPECT_EQ(world.velocity(post), Vector3(0, 0, 1));
  run_short(world, 60);
  EXPECT_NEAR((world.pose(post).position - world.pose(bob).position).norm(), 2, 1e-3) << "held together again";
}

TEST(EnabledBodies, QuarantineGoesFirst) {
  World world;
  const BodyId lost = world.add_body({.position = {1e13, 0, 0}});
  const BodyId off = world.add_body({.position = {0, 0, 5}});
  world.set_enabled(off, false);
  run_short(world, 1);
  ASSERT_TRUE(world.is_quarantined(lost));
  EXPECT_FALSE(world.is_quarantined(off));
  EXPECT_THROW(world.set_enabled(lost, false), Error);
  EXPECT_THROW(world.release(off), Error);
  world.remove_body(off);
  EXPECT_EQ(world.body_count(), 1u);
}

TEST(BodySleep, AnIslandSleepsAtOnceAndWakesTogether) {
  World world({.settings = {.sleeping = true}});
  world.add_body(ground());
  const BodyId lower = world.add_body(box({0, 0, 0.5}));
  const BodyId upper = world.add_body(box({0, 0, 1.5}));
  const BodyId faller = world.add_body({.shape = Sphere{0.2}, .position = {0, 0, 6}});
  run_short(world, 10);
  world.sleep(lower);
  EXPECT_TRUE(world.is_asleep(lower) && world.is_asleep(upper));
  EXPECT_FALSE(world.is_asleep(faller));
  world.sleep(faller);
  EXPECT_EQ(world.velocity(faller), Vector3::Zero());
  const double height = world.pose(faller).position.z();
  Snapshot snapshot;
  world.save(snapshot);
  run_short(world, 100);
  EXPECT_EQ(world.pose(faller).position.z(), height) << "nothing touches it";
  const std::uint64_t hash = world.state_hash();
  world.restore(snapshot);
  run_short(world, 100);
  EXPECT_EQ(world.state_hash(), hash);
  world.wake(faller);
  run_short(world, 240);
  EXPECT_FALSE(world.is_asleep(upper)) << "it was hit";
  EXPECT_FALSE(world.is_asleep(lower));
  EXPECT_THROW(world.sleep(world.bodies().front()), Error);
  world.set_settings({.sleeping = false});
  EXPECT_THROW(world.sleep(lower), Error);
}

TEST(BodyBounds, TheyAreThoseOfAllShapesAsTheyArePlaced) {
  World world;
  const Quaternion turned(Eigen::AngleAxisd(0.7853981633974483, Vector3::UnitZ()));
  const BodyId body =
      world.add_body({.shape = Compound{{{.shape = Box{{1, 1, 2}}}, {.shape = Sphere{0.5}, .position = {0, 0, 3}}}},
                      .position = {10, 0, 0},
                      .orientation = turned});
  const BoundingBox bounds = world.bounds(body);
  EXPECT_TRUE(bounds.lower.isApprox(Vector3(10 - std::sqrt(2), -std::sqrt(2), -2), 1e-12)) << bounds.lower.transpose();
  EXPECT_TRUE(bounds.upper.isApprox(Vector3(10 + std::sqrt(2), std::sqrt(2), 3.5), 1e-12)) << bounds.upper.transpose();
  EXPECT_EQ(world.bounds(world.add_body(ground())).upper.x(), std::numeric_limits<double>::infinity());
}

TEST(WorldTime, IsTheSumOfStepsAndGoesBackWithTheState) {
  World world;
  Snapshot snapshot;
  world.step(0.25);
  world.save(snapshot);
  world.step(0.5);
  EXPECT_EQ(world.time(), 0.75);
  world.restore(snapshot);
  EXPECT_EQ(world.time(), 0.25);
  World other;
  other.restore(snapshot);
  EXPECT_EQ(other.time(), 0.25);
}

}  // namespace
}  // namespace atl::test
