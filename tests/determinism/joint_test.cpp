// Joined bodies don't depend on what is asked between steps, nor on joints far away, and the last bit of a motor shows.
// Threads, restores and recordings are those of continued_test.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "support/tangle.h"

namespace atl::test::joint_test {
namespace {

constexpr int steps = 90;

class JointBits : public testing::TestWithParam<JointSolver> {};

TEST_P(JointBits, DoNotDependOnWhatIsAskedBetweenSteps) {
  const WorldDef def{.settings = {.joint_solver = GetParam()}};
  World world(def), other(def);
  Tangle asked(world), left_alone(other);
  for (int i = 0; i < steps; ++i) {
    asked.world.step(dt);
    left_alone.world.step(dt);
    for (const JointId joint : asked.joints) (void)asked.world.joint_state(joint);
    // Setting a joint to its own kind changes nothing except rest times, which are not used here.
    asked.world.set_joint(asked.joints[3], asked.world.joint(asked.joints[3]).kind);
    ASSERT_EQ(asked.world.state_hash(), left_alone.world.state_hash()) << i;
  }
}

// Joints that come far away have the graph of all made anew; what others hold is not in it.
TEST_P(JointBits, DoNotDependOnJointsThatComeFarAway) {
  const auto trail = [](bool joined) {
    World world({.settings = {.joint_solver = GetParam()}});
    Tangle tangle(world);
    const BodyId a = tangle.world.add_body(box({100, 0, 0.5}));
    const BodyId b = tangle.world.add_body(box({102, 0, 0.5}));
    std::vector<double> places;
    for (int i = 0; i < steps; ++i) {
      if (joined && i % 10 == 9) tangle.world.add_joint({.kind = FixedJoint{}, .first = a, .second = b});
      tangle.world.step(dt);
      for (const BodyId body : tangle.bodies) {
        for (const double x : tangle.world.pose(body).position) places.push_back(x);
      }
    }
    return places;
  };
  EXPECT_EQ(trail(true), trail(false));
}

TEST_P(JointBits, OneUlpOfAMotorTellsInEveryFollowingStep) {
  const WorldDef def{.settings = {.joint_solver = GetParam()}};
  World world(def), other(def);
  Tangle a(world), b(other);
  const auto hinge = [](double speed) { return HingeJoint{{.motor = JointMotor{speed, 5}}}; };
  a.world.set_joint(a.joints[1], hinge(2));
  b.world.set_joint(b.joints[1], hinge(std::nextafter(2, 3)));
  for (int i = 0; i < 10; ++i) {
    EXPECT_NE(a.world.state_hash(), b.world.state_hash()) << i;
    a.world.step(dt);
    b.world.step(dt);
  }
}

std::string solver_name(const testing::TestParamInfo<JointSolver>& info) {
  const char* names[] = {"Auto", "Iterative", "Direct"};
  return names[static_cast<std::size_t>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Solvers, JointBits,
                         testing::Values(JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct), solver_name);

}  // namespace
}  // namespace atl::test::joint_test
