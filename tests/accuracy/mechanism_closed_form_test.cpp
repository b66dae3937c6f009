// Mechanisms whose equations of motion are in textbooks, arms that are held still, and arms that reach.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/bodies.h"
#include "support/random.h"

namespace atl::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Thin rods that hang in a row by hinges about y; angles count from hanging straight down.
struct Rods {
  World world;
  BodyId hook;
  std::vector<BodyId> rods;
  std::vector<JointId> joints;

  explicit Rods(const std::vector<double>& lengths, const JointRange& range = {}) {
    hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = {.mask = 0}});
    double top = 0;
    for (const double length : lengths) {
      rods.push_back(world.add_body({.shape = Box{{0.01, 0.02, length / 2}},
                                     .position = {0, 0, top - length / 2},
                                     .mass = mass_of(length),
                                     .filter = {.mask = 0}}));
      const BodyId carrier = rods.size() == 1 ? hook : rods[rods.size() - 2];
      joints.push_back(world.add_joint(
          joint_at(world, HingeJoint{.angle = {.range = range}}, carrier, rods.back(), {0, 0, top}, {0, 1, 0})));
      top -= length;
    }
  }
  static double mass_of(double length) { return 2 * length; }
  /// kg m^2, about y and the centre.
  double inertia(std::size_t rod) const { return body_mass(world.definition(rods[rod])).inertia(1, 1); }
};

VectorXd vector_of(std::initializer_list<double> numbers) {
  VectorXd vector(static_cast<Eigen::Index>(numbers.size()));
  std::copy(numbers.begin(), numbers.end(), vector.begin());
  return vector;
}

TEST(MechanismClosedForm, PhysicalPendulum) {
  Rods rods({0.8});
  Mechanism mechanism(rods.world, rods.hook);
  const double mass = rods.world.mass(rods.rods[0]);
  for (const double angle : {-2.5, 0.0, 0.7, 3.0}) {
    mechanism.set(vector_of({angle}), vector_of({1.3}));
    const double moment = rods.inertia(0) + mass * 0.4 * 0.4;
    EXPECT_NEAR(mechanism.mass_matrix()(0, 0), moment, 1e-14);
    EXPECT_NEAR(mechanism.bias()[0], mass * g * 0.4 * std::sin(angle), 1e-13);
    EXPECT_NEAR(mechanism.forward_dynamics(vector_of({0.5}))[0], (0.5 - mass * g * 0.4 * std::sin(angle)) / moment,
                1e-11);
    EXPECT_NEAR(mechanism.kinetic_energy(), 0.5 * moment * 1.3 * 1.3, 1e-13);
    EXPECT_NEAR(mechanism.potential_energy(), -mass * g * 0.4 * std::cos(angle), 1e-13);
  }
}

// Spong, Hutchinson and Vidyasagar, "Robot Modeling and Control", 2006, section 7.3: the planar elbow manipulator.
TEST(MechanismClosedForm, DoublePendulum) {
  const double l1 = 0.8, l2 = 0.6;
  Rods rods({l1, l2});
  Mechanism mechanism(rods.world, rods.rods[1]);
  EXPECT_EQ(mechanism.base(), rods.hook);
  const double m1 = rods.world.mass(rods.rods[0]), m2 = rods.world.mass(rods.rods[1]);
  const double i1 = rods.inertia(0), i2 = rods.inertia(1);
  const double c1 = l1 / 2, c2 = l2 / 2, a = 0.9, b = -1.7, u = 2, w = -3;
  mechanism.set(vector_of({a, b}), vector_of({u, w}));
  const MatrixXd mass = mechanism.mass_matrix();
  const double off = m2 * (c2 * c2 + l1 * c2 * std::cos(b)) + i2;
  EXPECT_NEAR(mass(0, 0), m1 * c1 * c1 + i1 + m2 * (l1 * l1 + c2 * c2 + 2 * l1 * c2 * std::cos(b)) + i2, 1e-13);
  EXPECT_NEAR(mass(0, 1), off, 1e-13);
  EXPECT_NEAR(mass(1, 1), m2 * c2 * c2 + i2, 1e-13);
  const double h = -m2 * l1 * c2 * std::sin(b);
  const double pull = m2 * g * c2 * std::sin(a + b);
  const VectorXd bias = mechanism.bias();
  EXPECT_NEAR(bias[0], h * (2 * u * w + w * w) + (m1 * c1 + m2 * l1) * g * std::sin(a) + pull, 1e-12);
  EXPECT_NEAR(bias[1], -h * u * u + pull, 1e-12);
}

// Barto, Sutton and Anderson, 1983: the equations of a cart with a pole that stands at an angle of 0.
TEST(MechanismClosedForm, CartAndPole) {
  World world;
  const BodyId rail = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = {.mask = 0}});
  const BodyId cart = world.add_body({.shape = Box{{0.2, 0.1, 0.1}}, .mass = 1.5, .filter = {.mask = 0}});
  const BodyId pole =
      world.add_body({.shape = Box{{0.01, 0.01, 0.5}}, .position = {0, 0, 0.5}, .mass = 0.2, .filter = {.mask = 0}});
  world.add_joint(joint_at(world, SliderJoint{}, rail, cart, {0, 0, 0}, {1, 0, 0}));
  world.add_joint(joint_at(world, HingeJoint{}, cart, pole, {0, 0, 0}, {0, 1, 0}));
  Mechanism mechanism(world, cart);
  const double angle = 0.4, rate = 1.1, push = 3;
  mechanism.set(vector_of({0.7, angle}), vector_of({-0.5, rate}));
  const double l = 0.5, m = 0.2, all = 1.7, inertia = body_mass(world.definition(pole)).inertia(1, 1) + m * l * l;
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const double pushed = push + m * l * rate * rate * sine;
  const double turn =
      (m * g * l * sine - m * l * cosine * pushed / all) / (inertia - m * m * l * l * cosine * cosine / all);
  const VectorXd acceleration = mechanism.forward_dynamics(vector_of({push, 0}));
  EXPECT_NEAR(acceleration[1], turn, 1e-11);
  EXPECT_NEAR(acceleration[0], (pushed - m * l * turn * cosine) / all, 1e-12);
  EXPECT_LT((mechanism.jacobian(pole, {0, 0, 0.5}) * mechanism.v() -
             (VectorXd(6) << -0.5 + rate * cosine, 0, -rate * sine, 0, rate, 0).finished())
                .norm(),
            1e-12);
}

// A crank, a rod and a rocker: the joint in the middle of the loop is the one that is left out.
TEST(MechanismClosedForm, LoopsAreLeftOutAndNamed) {
  Rods rods({0.5, 0.5, 0.5});
  const JointId closing =
      rods.world.add_joint(joint_at(rods.world, HingeJoint{}, rods.rods[2], rods.hook, {0, 0, -1.5}, {0, 1, 0}));
  const Mechanism mechanism(rods.world, rods.rods[0]);
  EXPECT_EQ(mechanism.nv(), 3u);
  ASSERT_EQ(mechanism.loops().size(), 1u);
  EXPECT_EQ(mechanism.loops()[0], rods.joints[2]) << "the farthest from the base";
  EXPECT_EQ(mechanism.joints().back().joint, closing);
}

TEST(MechanismClosedForm, AFreeBaseKeepsItsMomentum) {
  World world({.gravity = Vector3::Zero()});
  const BodyId body = world.add_body({.shape = Box{{0.1, 0.2, 0.3}}, .mass = 2});
  Mechanism mechanism(world, body);
  ASSERT_TRUE(mechanism.is_floating());
  EXPECT_EQ(mechanism.nq(), 7u);
  VectorXd q(7), v(6);
  q << 1, 2, 3, 0, 0, 2, 0;
  v << 0.3, 0, 0, 1, 2, 3;
  mechanism.set(q, v);
  EXPECT_EQ(mechanism.q()[5], 1) << "a unit quaternion";
  // Euler's equations, turned about z by half a turn: the inertia is diagonal in these axes.
  const Vector3 moments = box_inertia(2, {0.1, 0.2, 0.3}), spin(1, 2, 3);
  const Vector3 expected = -spin.cross(Vector3(moments.cwiseProduct(spin))).cwiseQuotient(moments);
  const VectorXd acceleration = mechanism.forward_dynamics(VectorXd::Zero(6));
  EXPECT_LT((acceleration.tail<3>() - expected).norm(), 1e-12);
  EXPECT_LT(acceleration.head<3>().norm(), 1e-12);
}

TEST(MechanismClosedForm, AKinematicBaseCarriesItsTree) {
  Rods rods({0.8});
  const BodyId table = rods.world.add_body(
      {.type = BodyType::Kinematic, .shape = Sphere{0.1}, .angular_velocity = {0, 0, 2}, .filter = {.mask = 0}});
  const BodyId rod = rods.world.add_body(
      {.shape = Box{{0.01, 0.02, 0.4}}, .position = {0.5, 0, -0.4}, .mass = 1.6, .filter = {.mask = 0}});
  rods.world.add_joint(joint_at(rods.world, HingeJoint{}, table, rod, {0.5, 0, 0}, {0, 1, 0}));
  Mechanism mechanism(rods.world, table);
  mechanism.set(vector_of({0}), vector_of({0}));
  EXPECT_LT((rods.world.velocity(rod) - Vector3(0, 1, 0)).norm(), 1e-12);
  // About the hinge the centrifugal force of each part, m w^2 r, pulls outwards; r is that of the hinge throughout.
  EXPECT_NEAR(mechanism.bias()[0], 1.6 * 4 * 0.5 * 0.4, 1e-12);
}

// An arm that stands up is an unstable equilibrium: what holds it has to be exact. After a second it has crept by 3e-5
// rad in steps of 1/240 s, and by 2e-3 rad in steps of 1/60 s.
TEST(MechanismClosedForm, GravityCompensationHoldsAnArmStill) {
  Rods rods({0.6, 0.5, 0.3});
  Mechanism mechanism(rods.world, rods.hook);
  const VectorXd start = vector_of({2.2, -0.9, 1.1});
  mechanism.set(start, VectorXd::Zero(3));
  for (int i = 0; i < 240; ++i) {
    mechanism.apply(mechanism.gravity());
    rods.world.step(1.0 / 240);
  }
  EXPECT_LT((mechanism.q() - start).cwiseAbs().maxCoeff(), 1e-4);
  for (int i = 0; i < 60; ++i) rods.world.step(dt);
  EXPECT_GT((mechanism.q() - start).cwiseAbs().maxCoeff(), 0.5) << "without, it falls";
}

// Hinges about axes that alternate, as an arm with a spherical shoulder and wrist.
struct Arm {
  World world;
  BodyId ground, hand;

  Arm() {
    ground = world.add_body({.type = BodyType::Static, .shape = Sphere{0.01}, .filter = {.mask = 0}});
    BodyId carrier = ground;
    const Vector3 axes[] = {{0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}, {0, 1, 0}, {0, 0, 1}};
    double height = 0;
    for (const Vector3& axis : axes) {
      hand = world.add_body({.shape = Box{{0.03, 0.03, 0.1}}, .position = {0, 0, height + 0.1}, .filter = {.mask = 0}});
      world.add_joint(
          joint_at(world, HingeJoint{.angle = {.range = {-2.5, 2.5}}}, carrier, hand, {0, 0, height}, axis));
      carrier = hand;
      height += 0.2;
    }
  }
};

TEST(MechanismInverseKinematics, ReachesWhatIsWithinReach) {
  Random random(3);
  Arm arm;
  Mechanism mechanism(arm.world, arm.hand);
  const Vector3 tool(0, 0, 0.1);
  for (int trial = 0; trial < 50; ++trial) {
    VectorXd goal(7), start(7);
    for (int i = 0; i < 7; ++i) {
      goal[i] = random.real(-2.4, 2.4);
      start[i] = std::clamp(goal[i] + random.real(-0.5, 0.5), -2.5, 2.5);
    }
    mechanism.set(goal, VectorXd::Zero(7));
    const Pose pose = arm.world.pose(arm.hand);
    const Vector3 target = pose.position + pose.orientation * tool;
    mechanism.set(start, VectorXd::Zero(7));
    const std::uint64_t before = arm.world.state_hash();
    const InverseKinematics found = mechanism.inverse_kinematics(arm.hand, tool, target, pose.orientation);
    EXPECT_EQ(arm.world.state_hash(), before) << "nothing moves";
    EXPECT_LT(found.position_error, 1e-6) << trial;
    EXPECT_LT(found.angle_error, 1e-6) << trial;
    EXPECT_LE(found.q.cwiseAbs().maxCoeff(), 2.5) << "within the ranges";
    mechanism.set(found.q, VectorXd::Zero(7));
    const Pose reached = arm.world.pose(arm.hand);
    EXPECT_LT((reached.position + reached.orientation * tool - target).norm(), 1e-6);
    EXPECT_LT(reached.orientation.angularDistance(pose.orientation), 2e-6);
  }
}

TEST(MechanismInverseKinematics, TellsWhatIsOutOfReach) {
  Rods rods({0.8, 0.6});
  Mechanism mechanism(rods.world, rods.hook);
  mechanism.set(vector_of({0.3, 0.4}), VectorXd::Zero(2));
  const InverseKinematics far = mechanism.inverse_kinematics(rods.rods[1], {0, 0, -0.3}, {1.7, 0, 0});
  EXPECT_NEAR(far.position_error, 0.3, 1e-6);
  const InverseKinematics aside = mechanism.inverse_kinematics(rods.rods[1], {0, 0, -0.3}, {1, 0.2, 0});
  EXPECT_NEAR(aside.position_error, 0.2, 1e-9) << "out of the plane in which it moves";
  EXPECT_EQ(aside.angle_error, 0);
}

// An elbow that bends by no more than a quarter turn reaches no nearer than the third side of the triangle.
TEST(MechanismInverseKinematics, KeepsToRanges) {
  Rods rods({0.8, 0.6}, {-std::numbers::pi / 2, std::numbers::pi / 2});
  Mechanism mechanism(rods.world, rods.hook);
  mechanism.set(vector_of({0.3, 0.4}), VectorXd::Zero(2));
  const InverseKinematics near = mechanism.inverse_kinematics(rods.rods[1], {0, 0, -0.3}, {0.1, 0, -0.4});
  EXPECT_NEAR(near.position_error, 1 - std::hypot(0.1, 0.4), 1e-6);
  EXPECT_NEAR(std::abs(near.q[1]), std::numbers::pi / 2, 1e-12);
}

}  // namespace
}  // namespace atl::test
