// Turns of a SixDofJoint that are angles of hinges, each of which carries the next.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "support/motion.h"

namespace atl {
namespace {

constexpr double dt = 1.0 / 60;
constexpr JointAxis locked = {.range = {0, 0}};

Quaternion about(int axis, double angle) { return Quaternion(Eigen::AngleAxisd(angle, Vector3::Unit(axis))); }

Quaternion turned(SixDofTurns turns, const Vector3& angles) {
  return turns == SixDofTurns::AnglesXYZ ? about(0, angles.x()) * about(1, angles.y()) * about(2, angles.z())
                                         : about(0, angles.x()) * about(2, angles.z()) * about(1, angles.y());
}

/// A slab in space on a joint at its middle.
struct Gimbal {
  World world;
  BodyId base, slab;
  JointId joint;

  Gimbal(JointSolver solver, const SixDofJoint& kind, const Quaternion& orientation = Quaternion::Identity())
      : world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}}) {
    base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
    slab =
        world.add_body({.shape = Box{{0.1, 0.3, 0.5}}, .orientation = orientation, .mass = 1, .filter = {.mask = 0}});
    joint = world.add_joint({.kind = kind, .first = base, .second = slab});
  }
};

class SuccessiveTurns : public testing::TestWithParam<std::tuple<JointSolver, SixDofTurns>> {};

TEST_P(SuccessiveTurns, AreDrivenOneByOne) {
  const auto [solver, turns] = GetParam();
  SixDofJoint six = {.offset = {locked, locked, locked}, .turns = turns};
  const Vector3 targets(2.5, turns == SixDofTurns::AnglesXYZ ? -0.8 : -1.8, 0.7);
  for (int i = 0; i < 3; ++i) {
    const JointServo servo{.target = targets[i], .stiffness = 100, .damping = 30};
    six.turn[static_cast<std::size_t>(i)].motor = JointMotor{.max_force = unlimited, .servo = servo};
  }
  Gimbal gimbal(solver, six);
  for (int i = 0; i < 600; ++i) gimbal.world.step(dt);
  EXPECT_LT(gimbal.world.pose(gimbal.slab).orientation.angularDistance(turned(turns, targets)), 1e-4);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(gimbal.world.joint_state(gimbal.joint).position[static_cast<std::size_t>(3 + i)], targets[i], 1e-4);
  }
}

// Springs on all three, let go near where the outer two fade, so that they swing through it.
TEST_P(SuccessiveTurns, GainNoEnergyBySprings) {
  const auto [solver, turns] = GetParam();
  constexpr double stiffness = 0.04;
  SixDofJoint six = {.offset = {locked, locked, locked}, .turns = turns};
  for (JointAxis& axis : six.turn) axis.spring = JointSpring{.rest = 0, .stiffness = stiffness};
  const std::size_t middle = turns == SixDofTurns::AnglesXYZ ? 1 : 2;
  const double sign = middle == 1 ? 1 : -1;
  Vector3 start(1, 1, 1);
  start[static_cast<int>(middle)] = sign * 1.25;
  Gimbal gimbal(solver, six, turned(turns, start));
  const auto energy = [&] {
    const JointState state = gimbal.world.joint_state(gimbal.joint);
    double sum = test::motion_of(gimbal.world).kinetic;
    for (std::size_t i = 3; i < 6; ++i) sum += 0.5 * stiffness * state.position[i] * state.position[i];
    return sum;
  };
  gimbal.world.set_velocity(gimbal.slab, Vector3::Zero(), Vector3::Unit(static_cast<int>(middle)) * (5 * sign));
  const double before = energy();
  double widest = 0;
  for (int i = 0; i < 2400; ++i) {
    gimbal.world.step(dt / 4);
    const double between = std::abs(gimbal.world.joint_state(gimbal.joint).position[3 + middle]);
    widest = std::max(widest, between);
    if (between < 1.3) {
      ASSERT_LT(energy(), 1.001 * before) << "step " << i;
    }
  }
  EXPECT_GT(widest, 1.35);
}

INSTANTIATE_TEST_SUITE_P(All, SuccessiveTurns,
                         testing::Combine(testing::Values(JointSolver::Iterative, JointSolver::Direct),
                                          testing::Values(SixDofTurns::AnglesXYZ, SixDofTurns::AnglesXZY)));

// Two slides and a hinge, as of a robot in a plane: a body flies and turns on as if it were free, and its angle counts.
TEST(PlanarJoints, FlyAndTurnOn) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    const JointAxis free;
    Gimbal plane(solver, {.offset = {free, locked, free},
                          .turn = {locked, JointAxis{.armature = 1e-3}, locked},
                          .turns = SixDofTurns::AnglesXZY});
    plane.world.set_velocity(plane.slab, {2, 0, -1}, {0, 5, 0});
    for (int i = 0; i < 240; ++i) plane.world.step(dt);
    const JointState state = plane.world.joint_state(plane.joint);
    EXPECT_NEAR(state.position[0], 8, 1e-5);
    EXPECT_NEAR(state.position[2], -4, 1e-5);
    EXPECT_NEAR(state.position[4], 20, 1e-4) << "over three full turns";
    EXPECT_NEAR(state.speed[4], 5, 1e-6);
  }
}

}  // namespace
}  // namespace atl
