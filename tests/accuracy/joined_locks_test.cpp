// Joints hold bodies that are locked along or about axes as they hold others, which move along and about what is left.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/joined_run.h"
#include "support/random_assembly.h"

namespace atl::test::joined_locks_test {
namespace {

constexpr MotionLocks in_plane = MotionLocks::plane(Axis::Y);
constexpr MotionLocks on_rails = {.linear = {false, true, true}, .angular = {true, true, true}};
constexpr MotionLocks in_place = {.linear = {true, true, true}};

class JoinedLocks : public testing::TestWithParam<JointSolver> {
 protected:
  Settings settings() const { return {.joint_solver = GetParam()}; }
  bool direct() const { return GetParam() != JointSolver::Iterative; }
};

// Two rods and a wheel that spins: the hinges keep them in the plane without locks, too.
TEST_P(JoinedLocks, MechanismInItsPlaneMovesAsAFreeOneDoes) {
  const auto build = [&](World& world, const MotionLocks& locks) {
    std::vector<BodyId> ids = {world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 0.1, 0.1}}})};
    for (int i = 0; i < 3; ++i) {
      BodyDef def = box({i + 0.5, 0, 0}, {0.5, 0.1, 0.1});
      if (i == 2) def.angular_velocity = {0, 3, 0};
      ids.push_back(world.add_body(locked(def, locks)));
      const Vector3 at(i, 0, 0);
      world.add_joint(joint_at(world, HingeJoint{}, ids[ids.size() - 2], ids.back(), at, Vector3::UnitY()));
    }
    return ids;
  };
  World free({.settings = settings()}), planar({.settings = settings()});
  const std::vector<BodyId> a = build(free, {}), b = build(planar, in_plane);
  for (int step = 0; step < 120; ++step) {
    free.step(dt);
    planar.step(dt);
    for (std::size_t i = 1; i < a.size(); ++i) {
      EXPECT_LT((free.pose(a[i]).position - planar.pose(b[i]).position).norm(), direct() ? 1e-4 : 1e-2) << step;
      EXPECT_EQ(planar.velocity(b[i]).y(), 0);
      EXPECT_EQ(planar.angular_velocity(b[i]).x(), 0);
      EXPECT_EQ(planar.angular_velocity(b[i]).z(), 0);
    }
  }
  for (const JointId joint : planar.joints()) EXPECT_NEAR(planar.joint_state(joint).force.y(), 0, 1e-6);
}

// Small swings of a pole on a cart: (I + m l^2 - (m l)^2 / (M + m)) phi'' = -m g l phi.
TEST_P(JoinedLocks, PoleOnACartOnRailsSwingsAtItsFrequency) {
  World world({.settings = settings()});
  const double l = 0.5;
  const BodyId cart = world.add_body(locked(box({0, 0, 0}, {0.3, 0.1, 0.1}), on_rails));
  BodyDef def = box({l * std::sin(0.02), 0, -l * std::cos(0.02)}, {0.05, 0.05, 0.5});
  def.orientation = Quaternion(Eigen::AngleAxisd(-0.02, Vector3::UnitY()));
  const BodyId pole = world.add_body(def);
  JointDef ball{.kind = BallJoint{}, .first = cart, .second = pole, .frame_second = {{0, 0, l}}};
  world.add_joint(ball);
  const double cart_mass = body_mass(world.definition(cart)).mass;
  const MassProperties rod = body_mass(world.definition(pole));
  const double m = rod.mass;
  const double inertia = rod.inertia(1, 1) + m * l * l - m * m * l * l / (cart_mass + m);
  const double period = 2 * std::numbers::pi / std::sqrt(m * g * l / inertia);
  const double start = mechanical_energy(world, {cart, pole}),
               centre = cart_mass * world.pose(cart).position.x() + m * world.pose(pole).position.x();
  const double step = period / 100;
  run(world, 300, step);
  const double shift = cart_mass * world.pose(cart).position.x() + m * world.pose(pole).position.x() - centre;
  EXPECT_NEAR(shift / (cart_mass + m), 0, 1e-9) << "nothing pushes along the rails";
  const Vector3 down = world.pose(pole).orientation * Vector3(0, 0, -1);
  EXPECT_NEAR(down.x(), std::sin(0.02), direct() ? 2e-5 : 2e-3);
  EXPECT_EQ(world.pose(cart).position.y(), 0);
  EXPECT_EQ(world.pose(cart).position.z(), 0);
  EXPECT_EQ(world.pose(cart).orientation.coeffs(), Quaternion::Identity().coeffs());
  EXPECT_LT(mechanical_energy(world, {cart, pole}), start + 1e-3 * m * g * l);
}

TEST_P(JoinedLocks, LockedInEveryWayABodyCarriesAsAFixedOne) {
  const auto swing = [&](bool fixed) {
    World world({.settings = settings()});
    BodyDef def = box({0, 0, 0}, {0.1, 0.1, 0.1});
    if (fixed) {
      def.type = BodyType::Static;
    } else {
      def.locks = {{true, true, true}, {true, true, true}};
    }
    BodyId last = world.add_body(def);
    const BodyId top = last;
    std::vector<BodyId> ids;
    for (int i = 0; i < 4; ++i) {
      const BodyId next = world.add_body(box({i + 0.5, 0, 0}, {0.5, 0.05, 0.1}));
      world.add_joint({.kind = BallJoint{},
                       .first = last,
                       .second = next,
                       .frame_first = {{i == 0 ? 0.0 : 0.5, 0, 0}},
                       .frame_second = {{-0.5, 0, 0}}});
      ids.push_back(last = next);
    }
    run(world, 120);
    EXPECT_EQ(world.pose(top).position, Vector3::Zero());
    EXPECT_EQ(world.pose(top).orientation.coeffs(), Quaternion::Identity().coeffs());
    std::vector<Vector3> found;
    for (const BodyId id : ids) found.push_back(world.pose(id).position);
    return found;
  };
  const std::vector<Vector3> at_fixed = swing(true), at_locked = swing(false);
  for (std::size_t i = 0; i < at_fixed.size(); ++i) {
    EXPECT_LT((at_fixed[i] - at_locked[i]).norm(), direct() ? 1e-5 : 2e-2) << i;
  }
}

// A plate that turns about its centre, which stays: a body at its rim has the plate's inertia to carry about.
TEST_P(JoinedLocks, WhatStaysInPlaceTurnsUnderItsLoad) {
  World world({.settings = settings()});
  const BodyId plate = world.add_body(locked(box({0, 0, 0}, {1, 0.2, 0.1}), in_place));
  const BodyId weight = world.add_body(sphere({1, 0, -0.5}, 0.1));
  world.add_joint({.kind = BallJoint{},
                   .first = plate,
                   .second = weight,
                   .frame_first = {{1, 0, 0}},
                   .frame_second = {{0, 0, 0.5}}});
  const double start = mechanical_energy(world, {plate, weight});
  world.step(dt);
  // One rod's force F: F / (I / r^2) above, g - F / m below, the same.
  const double m = body_mass(world.definition(weight)).mass;
  const double inertia = body_mass(world.definition(plate)).inertia(1, 1);
  EXPECT_NEAR(world.velocity(weight).z(), -g * dt / (1 + inertia / m), direct() ? 1e-4 : 2e-2);
  for (int i = 0; i < 300; ++i) {
    world.step(dt);
    ASSERT_EQ(world.pose(plate).position, Vector3::Zero());
    ASSERT_LT(mechanical_energy(world, {plate, weight}), start + 0.01 * m * g);
  }
}

// A slider along an axis that is locked holds nothing but what it turns; a motor along it stalls.
TEST_P(JoinedLocks, WhatNothingMovesAlongTakesNoForce) {
  World world({.gravity = {0, -5, -g}, .settings = settings()});
  const BodyId rail = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 0.1, 0.1}}});
  const BodyId cart = world.add_body(locked(box({0, 0, 0}), in_plane));
  SliderJoint slider;
  slider.offset.motor = JointMotor{.speed = 1, .max_force = 100};
  const JointId joint = world.add_joint(joint_at(world, slider, rail, cart, Vector3::Zero(), Vector3::UnitY()));
  run(world, 120);
  EXPECT_LT(world.pose(cart).position.norm(), 1e-3);
  EXPECT_EQ(world.velocity(cart).y(), 0);
  const double weight = g * body_mass(world.definition(cart)).mass;
  const Vector3 force = world.joint_state(joint).force;
  EXPECT_NEAR(force.z(), weight, 1e-2 * weight);
  EXPECT_NEAR(force.y(), 0, 1e-6 * weight) << "the lock bears it";
}

// Locks that come while joints are there.
TEST_P(JoinedLocks, MayBeGivenToWhatIsJoined) {
  World world({.settings = settings()});
  const BodyId above = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 0.1, 0.1}}});
  const BodyId swing = world.add_body(box({0.5, 0, 0}, {0.5, 0.1, 0.1}));
  world.add_joint({.kind = BallJoint{}, .first = above, .second = swing, .frame_second = {{-0.5, 0, 0}}});
  world.apply_impulse(swing, {0, 50, 0}, {0.5, 0, 0});
  run(world, 30);
  EXPECT_GT(std::abs(world.velocity(swing).y()), 0.1);
  BodyDef def = world.definition(swing);
  def.locks = in_plane;
  world.set_definition(swing, def);
  const double y = world.pose(swing).position.y();
  for (int i = 0; i < 60; ++i) {
    world.step(dt);
    ASSERT_EQ(world.pose(swing).position.y(), y);
    ASSERT_EQ(world.angular_velocity(swing).x(), 0);
  }
  EXPECT_GT(world.velocity(swing).norm(), 0.1) << "it still swings in the plane";
  EXPECT_THROW(Mechanism(world, above), Error) << "coordinates know nothing of locks";
  def.locks = {};
  world.set_definition(swing, def);
  EXPECT_EQ(Mechanism(world, above).nv(), 3u);
}

std::string name(const testing::TestParamInfo<JointSolver>& info) { return solver_name(info.param); }
INSTANTIATE_TEST_SUITE_P(AllSolvers, JoinedLocks,
                         testing::Values(JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative), name);

}  // namespace
}  // namespace atl::test::joined_locks_test
