// Joints are internal forces: a ragdoll in free space, thrown with every part in a direction of its own, keeps its
// momentum and its angular momentum.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "support/joined_run.h"

namespace atl::test::joined_momentum_test {
namespace {

// Parts pass each other: contacts have levers of their own.
Scene thrown_ragdoll() {
  Scene scene = load_scene("ragdolls:count=1");
  scene.gravity.setZero();
  scene.settings.sleeping = false;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] {
    const double x = uniform(random), y = uniform(random);
    return Vector3(x, y, uniform(random));
  };
  for (SceneBody& body : scene.bodies) {
    body.def.angular_damping = 0;
    body.def.filter.mask = 0;
    if (body.def.type != BodyType::Dynamic) continue;
    body.def.velocity = 2 * vector();
    body.def.angular_velocity = 3 * vector();
  }
  return scene;
}

class JoinedMomentumTest : public testing::TestWithParam<JointSolver> {};

TEST_P(JoinedMomentumTest, IsKept) {
  JoinedRun run(thrown_ragdoll(), GetParam());
  const MotionReport before = run.motion();
  double scale = 0;
  for (std::size_t i = 0; i < run.ids.size(); ++i) scale += run.masses[i].mass * run.world.velocity(run.ids[i]).norm();
  double linear = 0, angular = 0, gap = 0;
  for (int step = 0; step < 300; ++step) {
    ASSERT_EQ(run.world.step(dt).first_quarantined, -1);
    const MotionReport now = run.motion();
    linear = std::max(linear, (now.momentum - before.momentum).norm() / scale);
    angular = std::max(angular, (now.angular_momentum - before.angular_momentum).norm());
    gap = std::max(gap, run.drift().max);
  }
  // 2^-24 of the speeds an update, at random, and of levers that turn with the bodies only once a substep where joints
  // are solved one by one.
  const bool direct = GetParam() == JointSolver::Direct;
  EXPECT_LT(linear, direct ? 2e-6 : 6e-6);
  EXPECT_LT(angular, (direct ? 1e-4 : 3e-3) * before.angular_momentum.norm());
  EXPECT_LT(gap, direct ? 1e-6 : 0.02);
}

INSTANTIATE_TEST_SUITE_P(Solvers, JoinedMomentumTest, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

}  // namespace
}  // namespace atl::test::joined_momentum_test
