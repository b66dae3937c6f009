// Same bits, always: of what tendons couple, whatever the number of threads, restored, and replayed.

#include <atoll/recording.h>
#include <atoll/snapshot.h>
#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/temporary_file.h"

namespace atl::test::tendon_bits_test {
namespace {

// Hands that fall on a table and on each other: fingers of two links on a palm, all closed by one motor over a tendon,
// each second link by a polynomial of the first.
struct Hands {
  World world;
  std::vector<JointId> tendons;

  explicit Hands(const WorldDef& def) : world(def) {
    world.add_body(ground());
    // Tendons get indices ahead of their joints': where these were.
    const BodyId a = world.add_body(box({20, 0, 0.5})), b = world.add_body(box({22, 0, 0.5}));
    std::vector<JointId> before;
    for (int i = 0; i < 9; ++i) before.push_back(world.add_joint({.kind = BallJoint{}, .first = a, .second = b}));
    std::vector<std::array<JointId, 6>> joints;
    for (int hand = 0; hand < 3; ++hand) joints.push_back(add_hand({0.1 * hand, 0, 0.5 + 0.8 * hand}));
    for (const JointId id : before) world.remove_joint(id);
    for (const auto& of : joints) couple(of);
  }

 private:
  std::array<JointId, 6> add_hand(const Vector3& at) {
    std::array<JointId, 6> joints;
    const BodyId palm = world.add_body(box(at, {0.2, 0.2, 0.05}));
    for (std::size_t finger = 0; finger < 3; ++finger) {
      const Quaternion turn(Eigen::AngleAxisd(2.1 * static_cast<double>(finger), Vector3::UnitZ()));
      BodyId base = palm;
      for (std::size_t link = 0; link < 2; ++link) {
        const double out = 0.2 + 0.3 * static_cast<double>(link);
        BodyDef def = box(at + turn * Vector3(out + 0.16, 0, 0), {0.13, 0.04, 0.03});
        def.orientation = turn;
        const BodyId next = world.add_body(def);
        joints[2 * finger + link] = world.add_joint(joint_at(world, HingeJoint{{.range = {-1.5, 1.5}}}, base, next,
                                                             at + turn * Vector3(out, 0, 0), turn * Vector3::UnitY()));
        base = next;
      }
    }
    return joints;
  }

  void couple(const std::array<JointId, 6>& joints) {
    TendonJoint closing{.length = {.motor = JointMotor{.speed = 1, .max_force = 3}, .friction = 0.1}};
    for (std::size_t finger = 0; finger < 3; ++finger) {
      closing.terms.push_back({.joint = joints[2 * finger], .polynomial = {0, 1.0 / 3}});
      tendons.push_back(
          world.add_joint({.kind = TendonJoint{.terms = {{.joint = joints[2 * finger + 1]},
                                                         {.joint = joints[2 * finger], .polynomial = {0, -0.7, 0.1}}},
                                               .length = {.range = {0, 0}}}}));
    }
    tendons.push_back(world.add_joint({.kind = closing}));
  }
};

constexpr int steps = 60;

WorldDef definition(JointSolver solver, int threads = 1) {
  return {.threads = threads, .settings = {.joint_solver = solver}};
}

class TendonBits : public testing::TestWithParam<JointSolver> {};

TEST_P(TendonBits, DoNotDependOnThreads) {
  Hands one(definition(GetParam()));
  Hands two(definition(GetParam(), 2));
  for (int i = 0; i < steps; ++i) {
    one.world.step(dt);
    two.world.step(dt);
    ASSERT_EQ(one.world.state_hash(), two.world.state_hash()) << i;
  }
}

TEST_P(TendonBits, GoOnAfterARestoreAsWithout) {
  Hands hands(definition(GetParam()));
  Hands fresh(definition(GetParam()));
  Snapshot snapshot;
  for (int i = 0; i < steps; ++i) {
    if (i % 20 == 10) {
      hands.world.save(snapshot);
      fresh.world.restore(snapshot);
    }
    hands.world.step(dt);
    fresh.world.step(dt);
    if (i >= 10) {
      ASSERT_EQ(fresh.world.state_hash(), hands.world.state_hash()) << i;
    }
  }
}

TEST_P(TendonBits, AreThoseOfAnEmptyWorldThatIsRestored) {
  Hands hands(definition(GetParam()));
  run(hands.world, 10);
  Snapshot snapshot;
  hands.world.save(snapshot);
  World empty(definition(GetParam()));
  empty.restore(snapshot);
  EXPECT_EQ(empty.state_hash(), hands.world.state_hash());
  run(empty, 10);
  run(hands.world, 10);
  EXPECT_EQ(empty.state_hash(), hands.world.state_hash());
}

TEST_P(TendonBits, AreReplayed) {
  const TemporaryFile file("tendons");
  Hands hands(definition(GetParam()));
  hands.world.record(file.path());
  for (int i = 0; i < steps; ++i) {
    if (i == 20) hands.world.set_motor_speed(hands.tendons.back(), -1);
    if (i == 40) hands.world.remove_joint(hands.tendons.front());
    hands.world.step(dt);
  }
  hands.world.stop_recording();
  EXPECT_FALSE(replay(file.path()).divergence);
}

INSTANTIATE_TEST_SUITE_P(Solvers, TendonBits, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) {
                           return std::string(solver.param == JointSolver::Direct ? "Direct" : "Iterative");
                         });

// An island that all workers sweep together: they share joints and contacts out, and one takes the tendon.
TEST(TendonBitsOfALargeIsland, DoNotDependOnThreads) {
  const auto hash_with = [](int threads) {
    World world(definition(JointSolver::Iterative, threads));
    BodyId before = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    std::vector<JointId> hinges;
    for (int i = 0; i < 2100; ++i) {
      const BodyId next = world.add_body(box({1.0 + i, 0, 0}, {0.4, 0.4, 0.4}));
      hinges.push_back(world.add_joint(joint_at(world, HingeJoint{}, before, next, {0.5 + i, 0, 0}, Vector3::UnitY())));
      before = next;
    }
    const JointId tendon = world.add_joint(
        {.kind = TendonJoint{.terms = {{.joint = hinges[3]}, {.joint = hinges[40], .polynomial = {0, -2}}},
                             .length = {.range = {0, 0}}}});
    run(world, 5);
    EXPECT_NE(world.joint_state(tendon).force.x(), 0);
    return world.state_hash();
  };
  EXPECT_EQ(hash_with(1), hash_with(2));
}

}  // namespace
}  // namespace atl::test::tendon_bits_test
