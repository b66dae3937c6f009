// Same bits, always: of joined bodies too, whatever the number of threads and the width of the vectors, and however
// their ids came about.

#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/variants.h"

namespace atl::test::joint_test {
namespace {

constexpr int steps = 90;

// Chains of all kinds of joints that fall on the ground and on each other.
struct Tangle {
  World world;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;

  explicit Tangle(const WorldDef& def) : world(def) {
    world.add_body(ground());
    const BodyId post = world.add_body(static_box({0, 0, 6}, {0.2, 0.2, 0.2}));
    const std::vector<JointKind> kinds = {
        BallJoint{.friction = 0.5},
        HingeJoint{{.range = {-0.5, 0.5}, .motor = JointMotor{2, 5}}},
        SliderJoint{{.range = {-0.1, 0.1, 0.7}, .spring = JointSpring{.hertz = 3}, .armature = 2}},
        HingeJoint{{.range = {-0.6, 0.4, 0.5}, .motor = JointMotor{0, 5, JointServo{0.2, 40, 2}}, .armature = 0.1}},
        FixedJoint{},
        UniversalJoint{.first = {.range = {-1, 1}}},
        ConeTwistJoint{.swing_limit = 0.4, .twist = {.range = {-0.3, 0.3}}},
        SixDofJoint{.offset = {JointAxis{}, JointAxis{.range = {0, 0}}, JointAxis{.range = {0, 0}}}},
    };
    for (int chain = 0; chain < 12; ++chain) {
      BodyId before = post;
      for (std::size_t i = 0; i < kinds.size(); ++i) {
        const JointKind& kind = kinds[(i + static_cast<std::size_t>(chain)) % kinds.size()];
        const double x = 0.5 + 0.6 * static_cast<double>(i);
        const BodyId next = world.add_body(box({x, 0.45 * chain, 3 + 0.3 * chain}, {0.25, 0.1, 0.1}));
        bodies.push_back(next);
        if (before != post || chain == 0) {
          joints.push_back(world.add_joint({.kind = kind,
                                            .first = before,
                                            .second = next,
                                            .frame_first = {{0.3, 0, 0}, Quaternion::Identity()},
                                            .frame_second = {{-0.3, 0, 0}, Quaternion::Identity()},
                                            .break_force = i == 5 ? 400 : unlimited}));
        }
        before = next;
      }
    }
  }
};

std::vector<std::uint64_t> trail(const WorldDef& def) {
  Tangle tangle(def);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < steps; ++i) {
    const StepReport report = tangle.world.step(dt);
    EXPECT_EQ(report.first_quarantined, -1) << i;
    hashes.push_back(tangle.world.state_hash());
  }
  return hashes;
}

class JointBits : public testing::TestWithParam<JointSolver> {};

TEST_P(JointBits, DoNotDependOnThreadsOrVectors) {
  const Settings settings{.joint_solver = GetParam(), .sleeping = true};
  const std::vector<std::uint64_t> expected = trail({.settings = settings});
  EXPECT_EQ(trail({.threads = 2, .settings = settings}), expected) << "two threads";
  for (const Simd simd : divergence::supported_simds()) {
    Settings with = settings;
    with.simd = simd;
    EXPECT_EQ(trail({.threads = 2, .settings = with}), expected) << name_of(simd);
  }
}

TEST_P(JointBits, GoOnAsTheyWereSaved) {
  const WorldDef def{.settings = {.joint_solver = GetParam()}};
  Tangle tangle(def);
  Tangle fresh(def);
  Snapshot snapshot;
  for (int i = 0; i < steps; ++i) {
    if (i % 20 == 10) {
      tangle.world.save(snapshot);
      fresh.world.restore(snapshot);
    }
    tangle.world.step(dt);
    fresh.world.step(dt);
    if (i >= 10) {
      ASSERT_EQ(fresh.world.state_hash(), tangle.world.state_hash()) << i;
    }
  }
}

TEST_P(JointBits, DoNotDependOnWhatIsAskedBetweenSteps) {
  const WorldDef def{.settings = {.joint_solver = GetParam()}};
  Tangle asked(def);
  Tangle left_alone(def);
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
    Tangle tangle({.settings = {.joint_solver = GetParam()}});
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
  Tangle a(def);
  Tangle b(def);
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
