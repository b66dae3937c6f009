// Ten rods in a row hang from a hook and swing without damping: energy neither drains nor grows. Long tests swing for a
// minute.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "support/joined_run.h"
#include "support/long_tests.h"
#include "support/min_turn.h"

namespace atl::test::pendulum_energy_test {
namespace {

constexpr int links = 10;
constexpr double length = 0.5;  // m

// Straight, at an angle from where it would hang.
Scene pendulum(double angle) {
  const Vector3 along(std::sin(angle), 0, -std::cos(angle));
  const Quaternion orientation = min_turn(Vector3::UnitX(), along);
  Scene scene;
  scene.bodies.push_back({.name = "hook", .def = {.type = BodyType::Static, .shape = Sphere{0.1}}});
  for (int i = 0; i < links; ++i) {
    const BodyDef rod = {.shape = Box{{length / 2, 0.02, 0.02}},
                         .position = (i + 0.5) * length * along,
                         .orientation = orientation,
                         .mass = 1,
                         .filter = {.mask = 0}};
    scene.bodies.push_back({.name = "", .def = rod});
    const std::size_t last = scene.bodies.size() - 1;
    const Vector3 end = i == 0 ? Vector3::Zero() : Vector3(length / 2, 0, 0);
    const JointDef def = {.kind = BallJoint{},
                          .frame_first = {end, Quaternion::Identity()},
                          .frame_second = {{-length / 2, 0, 0}, Quaternion::Identity()}};
    scene.joints.push_back({.name = "", .def = def, .first = last - 1, .second = last});
  }
  return scene;
}

/// The largest change of energy in so many seconds, over the weight times the length of all.
double energy_drift(double angle, int substeps, double seconds) {
  Scene scene = pendulum(angle);
  scene.settings.substeps = substeps;
  JoinedRun run(std::move(scene), JointSolver::Direct);
  const double start = run.energy();
  double worst = 0;
  for (int step = 0; step < std::lround(seconds / dt); ++step) {
    EXPECT_EQ(run.world.step(dt).first_quarantined, -1);
    worst = std::max(worst, std::abs(run.energy() - start));
  }
  return worst / (links * g * links * length);
}

// A small swing is an energy of 0.06% of that.
TEST(PendulumEnergy, IsKeptButForRoundingWhereMotionIsResolved) {
  for (const int substeps : {2, 4, 8, 16}) EXPECT_LT(energy_drift(0.05, substeps, 5), 1e-14) << substeps;
}

double seconds() { return long_tests() ? 60 : 15; }

TEST(PendulumEnergy, IsKeptForLong) {
  for (const int substeps : {4, 8, 16, 32}) EXPECT_LT(energy_drift(0.3, substeps, seconds()), 1e-12) << substeps;
}

// Released level it whips, at up to 90 rad/s, a third of a radian in a substep of 4 ms. Errors of a few percent then
// add up or not, so they don't fall from 4 to 8 substeps, and at 32 they come to 0.09 to 0.25 in a minute, by the
// angle.
TEST(PendulumEnergy, IsBoundedHoweverItWhips) {
  for (const int substeps : {4, 8, 16}) {
    EXPECT_LT(energy_drift(std::numbers::pi / 2, substeps, seconds()), 1) << substeps;
  }
  double sum = 0;
  for (const double angle : {1.45, 1.5, std::numbers::pi / 2, 1.6}) sum += energy_drift(angle, 32, seconds()) / 4;
  EXPECT_LT(sum, 0.2);
  EXPECT_LT(energy_drift(std::numbers::pi / 2, 64, seconds()), 0.05);
}

// The place of a pendulum after two seconds, seen from what it hangs on, which moves at a constant velocity.
Vector3 swung_on(const Vector3& velocity, int substeps) {
  World world({.settings = {.substeps = substeps}});
  const BodyType type = velocity.isZero() ? BodyType::Static : BodyType::Kinematic;
  const BodyId base = world.add_body({.type = type, .shape = Sphere{0.1}, .velocity = velocity, .filter = {.mask = 0}});
  const Vector3 hangs(std::sin(1.0) * 0.3, 0, -std::cos(1.0) * 0.3);
  const BodyId bob = world.add_body({.shape = Box{{0.1, 0.05, 0.2}},
                                     .position = hangs,
                                     .orientation = min_turn(-Vector3::UnitZ(), hangs),
                                     .velocity = velocity,
                                     .mass = 1,
                                     .filter = {.mask = 0}});
  world.add_joint(joint_at(world, HingeJoint{}, base, bob, {0, 0, 0}, Vector3::UnitY()));
  for (int i = 0; i < 120; ++i) world.step(dt);
  return world.pose(bob).position - world.pose(base).position;
}

// Joints do work on a body that is carried along, by what carries it: that is no energy that a solve has made.
TEST(PendulumEnergy, IsAsOnWhatStandsWhereWhatItHangsOnMoves) {
  const Vector3 right = swung_on(Vector3::Zero(), 64);
  for (const Vector3& velocity : {Vector3(0, 0, 2), Vector3(2, 0, 0), Vector3(0, 0, -10), Vector3(20, 0, 20)}) {
    EXPECT_LT((swung_on(velocity, 1) - right).norm(), 3e-3) << velocity.transpose();
    EXPECT_LT((swung_on(velocity, 4) - right).norm(), 2e-4) << velocity.transpose();
  }
}

// A rod on a hinge that a turntable carries round, half a metre off its axis, keeps its energy less the turntable's
// rate times its angular momentum (Jacobi's integral). Returns its largest change in a second, J.
double change_on_turntable(double rate, int substeps) {
  World world({.settings = {.substeps = substeps}});
  const Vector3 spin(0, 0, rate), at(0.5, 0, -0.3);
  const BodyId table = world.add_body(
      {.type = BodyType::Kinematic, .shape = Sphere{0.1}, .angular_velocity = spin, .filter = {.mask = 0}});
  const Matrix3 inertia = Vector3(0.01, 0.01, 0.002).asDiagonal();
  const BodyId rod = world.add_body({.shape = Sphere{0.1},
                                     .position = at,
                                     .velocity = spin.cross(at),
                                     .angular_velocity = spin,
                                     .mass = 1,
                                     .inertia = inertia,
                                     .filter = {.mask = 0}});
  world.add_joint(joint_at(world, HingeJoint{}, table, rod, {0.5, 0, 0}, Vector3::UnitY()));
  double start = 0, worst = 0;
  for (int i = 0; i <= 60; ++i) {
    if (i > 0) world.step(dt);
    const Matrix3 axes = world.pose(rod).orientation.toRotationMatrix();
    const Vector3 position = world.pose(rod).position, velocity = world.velocity(rod);
    const Vector3 momentum = axes * inertia * axes.transpose() * world.angular_velocity(rod);
    const double energy = 0.5 * (velocity.squaredNorm() + world.angular_velocity(rod).dot(momentum)) + g * position.z();
    const double integral = energy - rate * (position.cross(velocity) + momentum).z();
    if (i == 0) start = integral;
    worst = std::max(worst, std::abs(integral - start));
  }
  return worst;
}

// It whips at 25 rad/s, of an energy of 40 J.
TEST(PendulumEnergy, IsKeptOnATurntable) {
  EXPECT_LT(change_on_turntable(3, 4), 1e-3);
  EXPECT_LT(change_on_turntable(10, 4), 0.2);
  EXPECT_LT(change_on_turntable(10, 16), 0.01);
}

}  // namespace
}  // namespace atl::test::pendulum_energy_test
