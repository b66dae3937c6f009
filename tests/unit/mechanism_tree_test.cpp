// Which bodies and joints a mechanism takes, in which order, and what it refuses.

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Two arms of two rods on a wall, by hinges, and what else a test adds.
struct Wall {
  World world;
  BodyId wall;
  std::vector<BodyId> rods;
  std::vector<JointId> joints;

  Wall() {
    wall = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = {.mask = 0}});
    for (const double x : {0.0, 2.0}) {
      const BodyId upper = add_rod({x, 0, -0.5});
      const BodyId lower = add_rod({x, 0, -1.5});
      hang(HingeJoint{}, upper, lower, {x, 0, -1});
      hang(HingeJoint{}, wall, upper, {x, 0, 0});
    }
  }
  BodyId add_rod(const Vector3& position) {
    rods.push_back(world.add_body({.shape = Box{{0.05, 0.05, 0.5}}, .position = position, .filter = {.mask = 0}}));
    return rods.back();
  }
  JointId hang(const JointKind& kind, BodyId first, BodyId second, const Vector3& point, const std::string& name = "") {
    JointDef def = joint_at(world, kind, first, second, point, {0, 1, 0});
    def.name = name;
    joints.push_back(world.add_joint(def));
    return joints.back();
  }
};

std::vector<JointId> ids_of(const Mechanism& mechanism) {
  std::vector<JointId> ids;
  for (const MechanismJoint& joint : mechanism.joints()) ids.push_back(joint.joint);
  return ids;
}

TEST(MechanismTree, AnyBodyOfAnArmMeansThatArm) {
  Wall wall;
  for (const BodyId body : {wall.rods[2], wall.rods[3]}) {
    const Mechanism arm(wall.world, body);
    EXPECT_EQ(arm.base(), wall.wall);
    EXPECT_FALSE(arm.is_floating());
    EXPECT_EQ(arm.bodies(), (std::vector{wall.rods[2], wall.rods[3]})) << "from the base on";
    EXPECT_EQ(ids_of(arm), (std::vector{wall.joints[2], wall.joints[3]})) << "in order of their indices";
  }
  const Mechanism both(wall.world, wall.wall);
  EXPECT_EQ(both.nv(), 4u);
  EXPECT_EQ(ids_of(both), wall.joints);
  EXPECT_TRUE(both.loops().empty());
}

TEST(MechanismTree, WithoutAFixedBaseTheBodyIsAFreeOne) {
  Wall wall;
  wall.world.set_joint_enabled(wall.joints[1], false);
  const Mechanism arm(wall.world, wall.rods[1]);
  EXPECT_TRUE(arm.is_floating());
  EXPECT_EQ(arm.base(), wall.rods[1]);
  EXPECT_EQ(arm.nq(), 8u);
  EXPECT_EQ(arm.nv(), 7u);
  EXPECT_EQ(arm.joints()[0].joint, JointId{});
  EXPECT_EQ(arm.joints()[0].q_count, 7u);
  EXPECT_EQ(arm.joints()[1].q, 7u);
  EXPECT_EQ(arm.joints()[1].v, 6u);
}

TEST(MechanismTree, GearsRodsAndSecondHoldsAreLoops) {
  Wall wall;
  const BodyId other = wall.world.add_body(static_box({9, 0, 0}, {1, 1, 1}));
  const JointId gear = wall.hang(GearJoint{}, wall.rods[0], wall.rods[2], {0, 0, 0});
  const JointId rod = wall.world.add_joint({.kind = DistanceJoint{}, .first = wall.rods[1], .second = wall.rods[3]});
  const JointId held = wall.hang(BallJoint{}, other, wall.rods[3], {2, 0, -2});
  EXPECT_EQ(Mechanism(wall.world, wall.wall).loops(), (std::vector{gear, rod, held}));
  EXPECT_EQ(Mechanism(wall.world, wall.rods[1]).loops(), (std::vector{gear, rod})) << "another arm isn't held by these";
}

TEST(MechanismTree, LockedCoordinatesStayAtTheirValue) {
  Wall wall;
  wall.world.set_joint(wall.joints[0], HingeJoint{.angle = {.range = {0.5, 0.5}}});
  Mechanism arm(wall.world, wall.rods[0]);
  EXPECT_EQ(arm.nv(), 1u);
  EXPECT_EQ(arm.joints()[0].v_count, 0u);
  arm.set(VectorXd::Zero(1), VectorXd::Ones(1));
  EXPECT_NEAR(wall.world.joint_state(wall.joints[0]).position[0], 0.5, 1e-15);
  wall.world.set_joint(wall.joints[0], HingeJoint{});
  expect_error([&] { (void)arm.q(); }, {"coordinate 0 of joint (index 0", "was unlocked", "make another one"});
}

TEST(MechanismTree, AnglesAreSetOverFullTurns) {
  Wall wall;
  wall.world.set_joint(wall.joints[1], HingeJoint{.angle = {.range = {-3, 9}}});
  Mechanism arm(wall.world, wall.rods[0]);
  VectorXd q(2);
  for (const double angle : {2.9, -2.9, 8.5, 0.1}) {
    q << 0.2, angle;
    arm.set(q, VectorXd::Zero(2));
    EXPECT_NEAR(arm.q()[1], angle, 1e-12) << "not a turn away, beyond its range";
    wall.world.step(1e-4);
    EXPECT_NEAR(arm.q()[1], angle, 1e-3);
  }
}

TEST(MechanismTree, MassesAndArmaturesAreThoseOfNow) {
  Wall wall;
  const Mechanism arm(wall.world, wall.rods[0]);
  const Eigen::MatrixXd before = arm.mass_matrix();
  wall.world.set_mass(wall.rods[0], 2 * wall.world.mass(wall.rods[0]));
  wall.world.set_mass(wall.rods[1], 2 * wall.world.mass(wall.rods[1]));
  wall.world.set_joint(wall.joints[1], HingeJoint{.angle = {.armature = 3}});
  Eigen::MatrixXd expected = 2 * before;
  expected(1, 1) += 3;
  EXPECT_LT((arm.mass_matrix() - expected).norm(), 1e-9);
}

TEST(MechanismTree, RefusesOtherCoordinatesByTheJointsName) {
  for (const JointKind& kind :
       std::initializer_list<JointKind>{ConeTwistJoint{}, SixDofJoint{.turn = {JointAxis{.range = {0, 0}}}},
                                        SixDofJoint{.turn = {JointAxis{.armature = 1}}}}) {
    Wall wall;
    wall.hang(kind, wall.rods[1], wall.add_rod({0, 0, -2.5}), {0, 0, -2}, "wrist");
    expect_error([&] { Mechanism(wall.world, wall.wall); }, {"joint 'wrist' (index 4", "expected hinges"});
    EXPECT_NO_THROW(Mechanism(wall.world, wall.rods[3])) << "the other arm";
  }
}

TEST(MechanismTree, RefusesBasesThatCarryNothing) {
  Wall wall;
  const BodyId alone = wall.world.add_body(static_box({9, 0, 0}, {1, 1, 1}));
  expect_error([&] { Mechanism(wall.world, alone); }, {"no joint hangs a dynamic body", "expected a base"});
  wall.world.remove_body(alone);
  expect_error([&] { Mechanism(wall.world, alone); }, {"Mechanism", "no body has the id"});
}

TEST(MechanismTree, SaysThatTheWorldHasChanged) {
  const auto changed = [](const std::function<void(Wall&)>& change, std::initializer_list<std::string_view> words) {
    Wall wall;
    const Mechanism arm(wall.world, wall.rods[0]);
    change(wall);
    expect_error([&] { (void)arm.mass_matrix(); }, words);
  };
  changed([](Wall& wall) { wall.world.remove_body(wall.rods[1]); }, {"no body has the id"});
  changed([](Wall& wall) { wall.world.remove_joint(wall.joints[0]); }, {"was removed", "make another one"});
  changed([](Wall& wall) { wall.world.set_joint_enabled(wall.joints[0], false); }, {"is no longer enabled"});
  changed([](Wall& wall) { wall.hang(BallJoint{}, wall.rods[1], wall.rods[3], {0, 0, 0}); }, {"joints came to bodies"});
  changed(
      [](Wall& wall) {
        wall.world.set_velocity(wall.rods[1], {1e9, 0, 0}, {0, 0, 0});
        wall.world.step(dt);
      },
      {"is in quarantine"});
}

TEST(MechanismTree, RefusesWrongNumbers) {
  Wall wall;
  Mechanism arm(wall.world, wall.rods[0]);
  VectorXd two = VectorXd::Zero(2), bad(2);
  bad << 0, nan;
  const VectorXd three = VectorXd::Zero(3);
  expect_error([&] { arm.set(three, two); }, {"Mechanism::set: q has 3 numbers", "expected 2"});
  expect_error([&] { arm.set(two, bad); }, {"Mechanism::set: v[1] is nan", "expected a finite number"});
  expect_error([&] { arm.apply(three); }, {"Mechanism::apply: tau has 3 numbers"});
  expect_error([&] { (void)arm.inverse_dynamics(bad); }, {"acceleration[1] is nan"});
  expect_error([&] { (void)arm.forward_dynamics(three); }, {"tau has 3 numbers"});
  expect_error([&] { (void)arm.integrate(two, three); }, {"Mechanism::integrate: v has 3 numbers"});
  expect_error([&] { (void)arm.jacobian(wall.rods[2]); }, {"not in the tree", "expected one of its 2 bodies"});
  expect_error([&] { (void)arm.jacobian(wall.rods[0], {nan, 0, 0}); }, {"Mechanism::jacobian: point"});
  expect_error([&] { (void)arm.inverse_kinematics(wall.rods[0], {0, 0, 0}, {nan, 0, 0}); }, {"target"});
  expect_error(
      [&] {
        (void)arm.inverse_kinematics(wall.rods[0], {0, 0, 0}, {0, 0, 0}, Quaternion(0, 0, 0, 0));
      },
      {"orientation"});
  wall.world.set_joint_enabled(wall.joints[1], false);
  Mechanism flying(wall.world, wall.rods[0]);
  VectorXd q = VectorXd::Zero(8);
  expect_error([&] { flying.set(q, VectorXd::Zero(7)); }, {"q[3:7] is (0, 0, 0, 0)", "expected a quaternion"});
}

}  // namespace
}  // namespace atl::test
