// Joints whose frames start apart, by any angle: they come together, at no more speed than that takes.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/random.h"

namespace atl {
namespace {

using test::Random;

constexpr double dt = 1.0 / 60;

struct Pair {
  World world;
  BodyId first, second;

  Pair(JointSolver solver, bool fixed) : world({.gravity = {0, 0, 0}, .settings = {.joint_solver = solver}}) {
    first = world.add_body(
        {.type = fixed ? BodyType::Static : BodyType::Dynamic, .shape = Box{{0.5, 0.2, 0.1}}, .position = {0, 0, 0}});
    second = world.add_body({.shape = Box{{0.5, 0.1, 0.2}}, .position = {1.2, 0, 0}});
  }

  double fastest() const {
    double max = 0;
    for (const BodyId body : {first, second}) {
      max = std::max({max, world.velocity(body).norm(), world.angular_velocity(body).norm()});
    }
    return max;
  }
};

class JointStart : public testing::TestWithParam<JointSolver> {};

// Five rows of a hinge have another solution, with the axes opposed, where a spring about them pushes the wrong way.
TEST_P(JointStart, HingesTurnTheirAxesTogetherFromAnywhere) {
  Random random(3);
  for (int i = 0; i < 60; ++i) {
    Pair pair(GetParam(), i % 2 == 0);
    const Pose frame_first{{0.6, 0, 0}, random.rotation()};
    const Pose frame_second{{-0.6, 0, 0}, random.rotation()};
    pair.world.add_joint({.kind = HingeJoint{{.spring = JointSpring{.hertz = 2, .damping_ratio = 0.5}}},
                          .first = pair.first,
                          .second = pair.second,
                          .frame_first = frame_first,
                          .frame_second = frame_second});
    double fastest = 0;
    for (int step = 0; step < 900; ++step) {
      pair.world.step(dt);
      fastest = std::max(fastest, pair.fastest());
    }
    const Vector3 x_first = pair.world.pose(pair.first).orientation * (frame_first.orientation * Vector3::UnitX());
    const Vector3 x_second = pair.world.pose(pair.second).orientation * (frame_second.orientation * Vector3::UnitX());
    EXPECT_GT(x_first.dot(x_second), 1 - 1e-6) << i;
    EXPECT_LT(fastest, 100) << i;
    // To put frames together from afar leaves a free pair some spin.
    EXPECT_LT(pair.fastest(), i % 2 == 0 ? 0.1 : 5) << i;
  }
}

// Also where the square of what they lack is no number that a double holds.
TEST_P(JointStart, AxesThatAreAllButOpposedTellFiniteForces) {
  for (const double from_opposed : {0.0, 1e-200, 1e-155, 1e-20, 1e-15, 1e-12}) {
    Pair pair(GetParam(), false);
    const Quaternion opposed(from_opposed, from_opposed, 0, 1);
    const JointId hinge = pair.world.add_joint(
        {.kind = HingeJoint{}, .first = pair.first, .second = pair.second, .frame_second = {{0, 0, 0}, opposed}});
    for (int step = 0; step < 300; ++step) {
      ASSERT_EQ(pair.world.step(dt).quarantined, 0) << from_opposed;
      const JointState state = pair.world.joint_state(hinge);
      ASSERT_TRUE(state.torque.allFinite() && state.force.allFinite()) << from_opposed << ", step " << step;
    }
  }
}

// From a spin axis along the steering axis, which has no direction to turn it by, to one at a right angle.
TEST_P(JointStart, WheelsAndCrossesTurnTheirAxesToARightAngle) {
  for (const double angle : {0.0, 1e-9, 1e-3, 0.006, 0.1, 0.5, 1.0, std::numbers::pi / 2, 3.0, std::numbers::pi}) {
    for (const bool wheel : {true, false}) {
      Pair pair(GetParam(), false);
      // Angle of the second frame's y axis from the first's z axis, or x axis for a wheel.
      const Vector3 axis = wheel ? Vector3::UnitX() : Vector3::UnitZ();
      const double from_y = wheel ? std::numbers::pi / 2 - angle : angle - std::numbers::pi / 2;
      const Quaternion turned(Eigen::Quaterniond(Eigen::AngleAxisd(from_y, axis)));
      pair.world.add_joint({.kind = wheel ? JointKind(WheelJoint{}) : JointKind(UniversalJoint{}),
                            .first = pair.first,
                            .second = pair.second,
                            .frame_first = {{1.2, 0, 0}},
                            .frame_second = {{0, 0, 0}, turned}});
      double fastest = 0;
      for (int step = 0; step < 300; ++step) {
        ASSERT_EQ(pair.world.step(dt).quarantined, 0) << angle;
        fastest = std::max(fastest, pair.fastest());
      }
      EXPECT_LT(fastest, 100) << angle << (wheel ? ", wheel" : ", cross");
      const Vector3 along = wheel ? Vector3::UnitZ() : Vector3::UnitX();
      const Vector3 first = pair.world.pose(pair.first).orientation * along;
      const Vector3 second = pair.world.pose(pair.second).orientation * (turned * Vector3::UnitY());
      EXPECT_NEAR(first.dot(second), 0, 1e-3) << angle << (wheel ? ", wheel" : ", cross");
    }
  }
}

// The reported force of a joint equals the body's change of momentum, be the joint 1 mm open or out of reach. Moving
// bodies to close a gap gives them no velocity, and doesn't break a joint that can break.
TEST_P(JointStart, TheForceWhileAGapClosesIsThatOnTheBody) {
  for (const double gap : {1e-3, 0.1, 1.0, 10.0, 1e4}) {
    Pair pair(GetParam(), true);
    pair.world.set_settings({.substeps = 1, .joint_solver = GetParam()});
    const JointId joint = pair.world.add_joint({.kind = BallJoint{},
                                                .first = pair.first,
                                                .second = pair.second,
                                                .frame_first = {{0.6 - gap, 0, 0}, Quaternion::Identity()},
                                                .frame_second = {{-0.6, 0.03, 0}, Quaternion::Identity()}});
    const double mass = pair.world.mass(pair.second);
    for (int step = 0; step < 60; ++step) {
      const Vector3 before = mass * pair.world.velocity(pair.second);
      pair.world.step(dt);
      const Vector3 change = mass * pair.world.velocity(pair.second) - before;
      const Vector3 reported = dt * pair.world.joint_state(joint).force;
      EXPECT_LT((reported - change).norm(), 1e-6 * mass + 1e-5 * change.norm()) << gap << " m, step " << step;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, JointStart,
                         testing::Values(JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct));

}  // namespace
}  // namespace atl
