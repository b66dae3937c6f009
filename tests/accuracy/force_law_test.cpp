// Forces that a law gives for each substep, against closed forms: of second order where nothing touches.

#include <atoll/forces.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "support/bodies.h"
#include "support/min_turn.h"

namespace atl::test::force_law_test {
namespace {

constexpr double pi = std::numbers::pi;

/// The order in which errors fall from a step of 1/60 s to one a quarter as long.
template <typename Error>
double order_of(const Error& error) {
  return std::log2(error(1.0 / 60) / error(1.0 / 240)) / 2;
}

/// How far a body of 2 kg on a spring and a damper by law is from its closed form, at worst, as a share of the
/// amplitude of 1 m. Angular frequency 2 pi rad/s, 10 s.
double oscillator_error(double step, double damping_ratio) {
  constexpr double mass = 2, omega = 2 * pi;
  World world({.gravity = Vector3::Zero()});
  const BodyId id = world.add_body({.shape = Sphere{0.1}, .position = {1, 0, 0}, .mass = mass});
  const ForceLaw law = [&](Forces& forces) {
    const Vector3 x = forces.world().pose(id).position, v = forces.world().velocity(id);
    forces.add(id, -mass * omega * omega * x - 2 * mass * damping_ratio * omega * v);
  };
  const double decay = damping_ratio * omega, turn = std::sqrt(omega * omega - decay * decay);
  double worst = 0;
  for (int i = 1; i <= std::lround(10 / step); ++i) {
    world.step(step, law);
    const double t = i * step;
    const double x = std::exp(-decay * t) * (std::cos(turn * t) + decay / turn * std::sin(turn * t));
    worst = std::max(worst, std::abs(world.pose(id).position.x() - x));
  }
  return worst;
}

TEST(ForceLaw, AnOscillatorIsOfSecondOrder) {
  EXPECT_LT(oscillator_error(1.0 / 60, 0), 0.003);
  EXPECT_GT(order_of([](double step) { return oscillator_error(step, 0); }), 1.95);
  EXPECT_LT(oscillator_error(1.0 / 60, 0.1), 0.001);
  EXPECT_GT(order_of([](double step) { return oscillator_error(step, 0.1); }), 1.95);
}

TEST(ForceLaw, AnOscillatorKeepsItsEnergy) {
  constexpr double stiffness = 40;
  World world({.gravity = Vector3::Zero()});
  const BodyId id = world.add_body({.shape = Sphere{0.1}, .position = {1, 0, 0}, .mass = 1.0});
  const ForceLaw law = [&](Forces& forces) { forces.add(id, -stiffness * forces.world().pose(id).position); };
  const double start = 0.5 * stiffness;
  for (int i = 0; i < 6000; ++i) {
    world.step(dt, law);
    const double now = 0.5 * world.velocity(id).squaredNorm() + 0.5 * stiffness * world.pose(id).position.squaredNorm();
    ASSERT_NEAR(now, start, 1e-3 * start) << "step " << i;
  }
}

/// A rod on a hinge at the origin, turning about y, with what the law does to it.
struct HungRod {
  static constexpr double length = 1, mass = 3;
  World world;
  BodyId rod;

  explicit HungRod(JointSolver solver, double angle = 0, int substeps = 4, const JointAxis& axis = {},
                   double gravity = g)
      : world({.gravity = {0, 0, -gravity}, .settings = {.substeps = substeps, .joint_solver = solver}}) {
    const Quaternion turn(Eigen::AngleAxisd(angle, Vector3::UnitY()));
    const BodyId post = world.add_body(static_box({0, 0.5, 0}, {0.05, 0.05, 0.05}));
    rod = world.add_body({.shape = Box{{length / 2, 0.02, 0.02}},
                          .position = turn * Vector3(length / 2, 0, 0),
                          .orientation = turn,
                          .mass = mass});
    const Quaternion along = min_turn(Vector3::UnitX(), Vector3::UnitY());
    world.add_joint({.kind = HingeJoint{axis},
                     .first = post,
                     .second = rod,
                     .frame_first = {.position = {0, -0.5, 0}, .orientation = along},
                     .frame_second = {.position = {-length / 2, 0, 0}, .orientation = along}});
  }
  double angle() const {
    const Vector3 along = world.pose(rod).orientation * Vector3::UnitX();
    return std::atan2(-along.z(), along.x());
  }
  double spin() const { return world.angular_velocity(rod).y(); }
  Vector3 tip() const { return world.pose(rod).position + world.pose(rod).orientation * Vector3(length / 2, 0, 0); }
  double speed_of_pivot() const {
    const Vector3 arm = world.pose(rod).orientation * Vector3(-length / 2, 0, 0);
    return (world.velocity(rod) + world.angular_velocity(rod).cross(arm)).norm();
  }
  double moment() const { return mass * (length * length / 3 + (0.02 * 0.02) / 3); }
};

/// Angle and rate, from those at `start` seconds, after some time of I a'' = torque(t, a, a'), by the classical
/// Runge-Kutta method.
template <typename Torque>
std::array<double, 2> integrate(const Torque& torque, double moment, double start, double time,
                                std::array<double, 2> y) {
  const auto steps = std::lround(time / 1e-4);
  const double h = time / static_cast<double>(steps);
  const auto rate = [&](double t, const std::array<double, 2>& s) {
    return std::array{s[1], torque(t, s[0], s[1]) / moment};
  };
  const auto moved = [](const std::array<double, 2>& s, double by, const std::array<double, 2>& along) {
    return std::array{s[0] + by * along[0], s[1] + by * along[1]};
  };
  for (int i = 0; i < steps; ++i) {
    const double t = start + i * h;
    const auto k1 = rate(t, y), k2 = rate(t + h / 2, moved(y, h / 2, k1)), k3 = rate(t + h / 2, moved(y, h / 2, k2)),
               k4 = rate(t + h, moved(y, h, k3));
    for (std::size_t k = 0; k < 2; ++k) y[k] += h / 6 * (k1[k] + 2 * k2[k] + 2 * k3[k] + k4[k]);
  }
  return y;
}

/// A spring of 40 N/m that the law holds between the rod's tip and a point, after 3 s.
double spring_error(double step, JointSolver solver) {
  constexpr double stiffness = 40;
  const Vector3 anchor(1.5, 0, 0.5);
  HungRod run(solver);
  const ForceLaw law = [&](Forces& forces) {
    const Vector3 tip = run.tip();
    forces.add_at(run.rod, stiffness * (anchor - tip), tip);
  };
  for (int i = 0; i < std::lround(3 / step); ++i) run.world.step(step, law);
  const auto torque = [&](double, double angle, double) {
    const Vector3 along(std::cos(angle), 0, -std::sin(angle));
    const Vector3 pull = stiffness * (anchor - HungRod::length * along);
    const Vector3 weight(0, 0, -HungRod::mass * g);
    return (HungRod::length * along.cross(pull) + 0.5 * HungRod::length * along.cross(weight)).y();
  };
  return std::abs(run.angle() - integrate(torque, run.moment(), 0, 3, {0, 0})[0]);
}

TEST(ForceLaw, ASpringOnAJoinedRodIsOfSecondOrder) {
  const auto direct = [](double step) { return spring_error(step, JointSolver::Direct); };
  EXPECT_LT(direct(1.0 / 60), 2e-3);
  EXPECT_GT(order_of(direct), 1.8);
  EXPECT_LT(spring_error(1.0 / 60, JointSolver::Iterative), 0.05);
}

/// A controller with gains on angle and speed that holds the rod level, whose set point swings. At worst in 3 s.
double controller_error(double step) {
  constexpr double stiffness = 300, damping = 12;
  HungRod run(JointSolver::Direct, 0.5);
  double now = 0, worst = 0;
  const auto target = [](double t) { return 0.2 * std::sin(3 * t); };
  const auto torque = [&](double t, double angle, double speed) {
    return stiffness * (target(t) - angle) - damping * speed;
  };
  const ForceLaw law = [&](Forces& forces) {
    forces.add(run.rod, Vector3::Zero(), {0, torque(now + forces.time(), run.angle(), run.spin()), 0});
  };
  const auto moves = [&](double t, double angle, double speed) {
    return torque(t, angle, speed) + HungRod::mass * g * HungRod::length / 2 * std::cos(angle);
  };
  std::array<double, 2> right = {0.5, 0};
  for (int i = 0; i < std::lround(3 / step); ++i, now += step) {
    run.world.step(step, law);
    right = integrate(moves, run.moment(), now, step, right);
    worst = std::max(worst, std::abs(run.angle() - right[0]));
  }
  return worst;
}

TEST(ForceLaw, AControllerIsOfSecondOrder) {
  EXPECT_LT(controller_error(1.0 / 60), 1e-3);
  EXPECT_GT(order_of(controller_error), 1.8);
}

/// The worst errors in the states that steps under a torque tell: the speed of the pivot's parting (m/s), angle and
/// rate (rad and rad/s) by I a'' = moves(t, a, a') with `inertia` beside that of the rod.
struct Told {
  double pivot = 0, angle = 0, rate = 0;
};

template <typename Torque, typename Moves>
Told told_by(HungRod run, double step, const Torque& torque, const Moves& moves, double inertia = 0) {
  Told told;
  double now = 0;
  const ForceLaw law = [&](Forces& forces) {
    forces.add(run.rod, Vector3::Zero(), {0, torque(now + forces.time()), 0});
  };
  std::array<double, 2> right = {0, 0};
  for (int i = 0; i < std::lround(1 / step); ++i, now += step) {
    run.world.step(step, law);
    right = integrate(moves, run.moment() + inertia, now, step, right);
    told.pivot = std::max(told.pivot, run.speed_of_pivot());
    told.angle = std::max(told.angle, std::abs(run.angle() - right[0]));
    told.rate = std::max(told.rate, std::abs(run.spin() - right[1]));
  }
  return told;
}

double wave(double t) { return 5 * std::sin(9 * t); }

using Way = std::tuple<JointSolver, int>;
class JoinedForceLaw : public testing::TestWithParam<Way> {
 protected:
  static bool swept() { return std::get<0>(GetParam()) == JointSolver::Iterative; }
  static HungRod rod_with(const JointAxis& axis, double gravity = 0) {
    return HungRod(std::get<0>(GetParam()), 0, std::get<1>(GetParam()), axis, gravity);
  }
};

// Half of what a law changes in the last substep goes by the joints, too.
TEST_P(JoinedForceLaw, VelocitiesAreToldThatKeepTheJoints) {
  const auto moves = [](double t, double angle, double) {
    return wave(t) + HungRod::mass * g * HungRod::length / 2 * std::cos(angle);
  };
  const auto told = [&](double step) { return told_by(rod_with({}, g), step, wave, moves); };
  EXPECT_LT(told(1.0 / 60).pivot, 1e-5);
  EXPECT_LT(told(1.0 / 60).rate, swept() ? 0.1 : 0.02);
  if (!swept()) {
    EXPECT_GT(order_of([&](double step) { return told(step).rate; }), 1.8);
  }
}

TEST_P(JoinedForceLaw, ARotorTurnsAlong) {
  const JointAxis axis = {.spring = JointSpring{.stiffness = 100, .damping = 3}, .armature = 0.4};
  const auto moves = [](double t, double angle, double rate) { return wave(t) - 100 * angle - 3 * rate; };
  const auto told = [&](double step) { return told_by(rod_with(axis), step, wave, moves, 0.4); };
  EXPECT_LT(told(1.0 / 60).angle, swept() ? 0.02 : 1e-3);
  EXPECT_LT(told(1.0 / 60).rate, swept() ? 0.05 : 5e-3);
  if (!swept()) {
    EXPECT_GT(order_of([&](double step) { return told(step).angle; }), 1.8);
  }
}

TEST_P(JoinedForceLaw, WhatHoldsTheRateHoldsItToldToo) {
  const auto holds = [](double, double, double) { return 0; };
  const auto press = [](double t) { return wave(t) - 6; };
  const double step = 1.0 / 60;
  EXPECT_LT(told_by(rod_with({.friction = 6}), step, wave, holds).rate, 1e-6);
  EXPECT_LT(told_by(rod_with({.motor = JointMotor{.max_force = 6}}), step, wave, holds).rate, 1e-6);
  EXPECT_LT(told_by(rod_with({.range = {0, 1}}), step, press, holds).rate, swept() ? 0.02 : 1e-6);
}

// A motor that gives all it has holds nothing back.
TEST_P(JoinedForceLaw, AMotorGivesNoMoreThanItHas) {
  const auto moves = [](double t, double, double) { return wave(t) + 2; };
  const JointAxis axis = {.motor = JointMotor{.speed = 100, .max_force = 2}};
  const auto told = [&](double step) { return told_by(rod_with(axis), step, wave, moves); };
  EXPECT_LT(told(1.0 / 60).rate, swept() ? 0.1 : 5e-3);
  if (!swept()) {
    EXPECT_GT(order_of([&](double step) { return told(step).rate; }), 1.8);
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, JoinedForceLaw,
                         testing::Combine(testing::Values(JointSolver::Auto, JointSolver::Direct,
                                                          JointSolver::Iterative),
                                          testing::Values(1, 4)));

TEST(ForceLaw, WhatRestsStaysAtRestUnderAForceThatChanges) {
  World world;
  const BodyId floor = world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  run(world, 60);
  const double weight = world.mass(crate) * g;
  double now = 0;
  const ForceLaw law = [&](Forces& forces) {
    forces.add(crate, {0, 0, -weight * (1 + std::sin(40 * (now + forces.time())))});
  };
  for (int i = 0; i < 120; ++i, now += dt) {
    world.step(dt, law);
    ASSERT_LT(world.velocity(crate).norm(), 1e-3) << "step " << i;
    ASSERT_NEAR(world.pose(crate).position.z(), 0.5, 2e-3) << "step " << i;
  }
  EXPECT_GT(contact_force(world, floor, crate).z(), 0);
}

}  // namespace
}  // namespace atl::test::force_law_test
