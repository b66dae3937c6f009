// A vehicle with its brakes on holds on a slope below the angle of friction and slips on one above. Gravity is tilted,
// not the ground.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "support/joined_run.h"

namespace atl::test::parked_vehicle_test {
namespace {

constexpr double friction = 0.6;
constexpr double degree = std::numbers::pi / 180;

struct ParkedVehicle {
  World world;
  BodyId chassis = {};

  ParkedVehicle(double slope, JointSolver solver)
      : world({.gravity = g * Vector3(std::sin(slope), 0, -std::cos(slope)), .settings = {.joint_solver = solver}}) {
    world.add_body(ground(friction));
    constexpr double radius = 0.3;
    const Vector3 centre(0, 0, radius + 0.15);
    BodyDef body = box(centre, {1, 0.5, 0.15});
    body.mass = 800;
    chassis = world.add_body(body);
    const WheelJoint brake = {
        .suspension = {.range = {-0.1, 0.1}, .spring = JointSpring{.hertz = 5, .damping_ratio = 0.7}},
        .spin = {.motor = JointMotor{.speed = 0, .max_force = 1e5}}};
    for (const double x : {-0.9, 0.9}) {
      for (const double y : {-0.6, 0.6}) {
        BodyDef ball = sphere({x, y, radius}, radius);
        ball.mass = 20;
        ball.material.friction = friction;
        const BodyId wheel = world.add_body(ball);
        world.add_joint({.kind = brake,
                         .first = chassis,
                         .second = wheel,
                         .frame_first = {ball.position - centre, Quaternion::Identity()}});
      }
    }
  }
  /// m, downhill, in so many seconds.
  double roll(double seconds) {
    const double start = world.pose(chassis).position.x();
    run(world, static_cast<int>(std::lround(seconds / dt)));
    return world.pose(chassis).position.x() - start;
  }
};

class ParkedVehicleTest : public testing::TestWithParam<JointSolver> {};

TEST_P(ParkedVehicleTest, HoldsBelowTheAngleOfFriction) {
  for (const double slope : {20 * degree, std::atan(friction) - 2 * degree}) {
    ParkedVehicle vehicle(slope, GetParam());
    const double first = vehicle.roll(1);  // comes down on its springs
    const double second = vehicle.roll(5);
    EXPECT_LT(std::abs(first), 0.02) << slope / degree;
    EXPECT_LT(std::abs(second), 1e-4) << slope / degree;
  }
}

TEST_P(ParkedVehicleTest, SlipsAboveIt) {
  const double slope = std::atan(friction) + 2 * degree;
  const double acceleration = g * (std::sin(slope) - friction * std::cos(slope));
  ParkedVehicle vehicle(slope, GetParam());
  vehicle.roll(1);
  const double before = vehicle.world.velocity(vehicle.chassis).x();
  vehicle.roll(2);
  const double gained = vehicle.world.velocity(vehicle.chassis).x() - before;
  EXPECT_NEAR(gained, 2 * acceleration, 0.01 * 2 * acceleration);
}

INSTANTIATE_TEST_SUITE_P(Solvers, ParkedVehicleTest, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

}  // namespace
}  // namespace atl::test::parked_vehicle_test
