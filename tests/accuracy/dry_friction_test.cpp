// Dry friction along a coordinate of a joint, alone and beside a spring, a servo, a motor and the end of a range:
// closed forms, however joints are solved, in finer steps, on any threads and from a snapshot on.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "support/joined_run.h"

namespace atl::test::dry_friction_test {
namespace {

constexpr double mass = 2;      // kg
constexpr double friction = 6;  // N

// A body on a rail along x, without gravity.
struct Sled {
  World world;
  BodyId body;

  Sled(JointSolver solver, const JointAxis& axis, double speed, int threads = 1)
      : world({.gravity = Vector3::Zero(), .threads = threads, .settings = {.joint_solver = solver}}) {
    const BodyId rail = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    body = world.add_body({.shape = Box{{0.2, 0.2, 0.2}}, .velocity = {speed, 0, 0}, .mass = mass});
    world.add_joint({.kind = SliderJoint{axis}, .first = rail, .second = body});
  }
  double place() const { return world.pose(body).position.x(); }
  double rate() const { return world.velocity(body).x(); }
  void run(double seconds, double step = dt) {
    for (int i = 0; i < std::lround(seconds / step); ++i) world.step(step);
  }
};

using Setup = std::tuple<JointSolver, double>;
class DryFriction : public testing::TestWithParam<Setup> {
 protected:
  JointSolver solver() const { return std::get<0>(GetParam()); }
  double step() const { return std::get<1>(GetParam()); }
};

TEST_P(DryFriction, StopsABody) {
  Sled sled(solver(), {.friction = friction}, 1.5);
  sled.run(0.25, step());
  EXPECT_NEAR(sled.rate(), 1.5 - friction / mass * 0.25, 1e-4);
  sled.run(0.75, step());
  EXPECT_NEAR(sled.rate(), 0, 1e-6);
  EXPECT_NEAR(sled.place(), 1.5 * 1.5 / (2 * friction / mass), 5e-3);
}

TEST_P(DryFriction, HoldsAgainstLessAndLetsMoreThrough) {
  for (const double force : {0.5 * friction, -0.99 * friction, 1.5 * friction, -3 * friction}) {
    Sled sled(solver(), {.friction = friction}, 0);
    for (int i = 0; i < std::lround(1 / step()); ++i) {
      sled.world.apply_force(sled.body, {force, 0, 0});
      sled.world.step(step());
    }
    const double left = std::copysign(std::max(std::abs(force) - friction, 0.0), force);
    EXPECT_NEAR(sled.rate(), left / mass, 1e-3 * std::abs(left / mass) + 1e-6) << force;
    EXPECT_NEAR(sled.place(), 0.5 * left / mass, 5e-3 * std::abs(left) + 1e-6) << force;
  }
}

// Each half swing ends nearer to the middle by 2 F / k, until a spring that pulls by less than F holds nothing (Meriam
// and Kraige, "Engineering Mechanics: Dynamics", 2012, 8/2).
TEST_P(DryFriction, TakesTheSameOffEachHalfSwing) {
  constexpr double stiffness = 200;  // N/m
  const double half_period = M_PI * std::sqrt(mass / stiffness);
  Sled sled(solver(), {.spring = JointSpring{.rest = 0.2, .stiffness = stiffness}, .friction = friction}, 0);
  const double finest = step() / 4;
  for (int half = 1; half <= 3; ++half) {
    sled.run(half_period, half_period / std::lround(half_period / finest));
    const double from_rest = (half % 2 == 1 ? 1 : -1) * (0.2 - 2 * half * friction / stiffness);
    EXPECT_NEAR(sled.place() - 0.2, from_rest, 2e-3) << half;
  }
  // After three of them the spring pulls by 200 N/m * 0.02 m.
  const double stuck = sled.place();
  sled.run(1);
  EXPECT_NEAR(sled.place(), stuck, 1e-3);
  EXPECT_NEAR(sled.rate(), 0, 1e-6);
}

// A servo gets no nearer than where it pulls by as much as friction, and doesn't stir what it can't move.
TEST_P(DryFriction, HoldsBackAServo) {
  const auto servo = [](double target, double force) {
    return JointMotor{.max_force = force, .servo = JointServo{.target = target, .stiffness = 300, .damping = 60}};
  };
  Sled still(solver(), {.motor = servo(0.9 * friction / 300, 1000), .friction = friction}, 0);
  still.run(2, step());
  EXPECT_NEAR(still.place(), 0, 1e-6);
  Sled sled(solver(), {.motor = servo(0.5, 1000), .friction = friction}, 0);
  sled.run(4, step());
  EXPECT_NEAR(sled.rate(), 0, 1e-6);
  EXPECT_LE(std::abs(0.5 - sled.place()) * 300, 1.01 * friction);
  EXPECT_GT(sled.place(), 0.45);
  // At its bound it is a constant force.
  Sled weak(solver(), {.motor = servo(100, 2 * friction), .friction = friction}, 0);
  weak.run(1, step());
  EXPECT_NEAR(weak.rate(), friction / mass, 2e-3 * friction / mass);
}

TEST_P(DryFriction, ActsBesideAMotorAndAtAnEnd) {
  const JointMotor motor{.speed = 1, .max_force = 2.5 * friction};
  Sled sled(solver(), {.motor = motor, .friction = friction}, 0);
  sled.run(0.1, step());
  EXPECT_NEAR(sled.rate(), 1.5 * friction / mass * 0.1, 1e-3);
  sled.run(1, step());
  EXPECT_NEAR(sled.rate(), 1, 1e-3) << "its speed";
  Sled ended(solver(), {.range = {-1, 0.05}, .friction = friction}, 1);
  ended.run(2, step());
  EXPECT_NEAR(ended.place(), 0.05, 2e-3);
  EXPECT_NEAR(ended.rate(), 0, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Solvers, DryFriction,
                         testing::Combine(testing::Values(JointSolver::Iterative, JointSolver::Direct),
                                          testing::Values(1.0 / 60, 1.0 / 240)),
                         [](const auto& setup) {
                           return solver_name(std::get<0>(setup.param)) +
                                  (std::get<1>(setup.param) > 0.01 ? "" : "Fine");
                         });

}  // namespace
}  // namespace atl::test::dry_friction_test
