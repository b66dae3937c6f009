// Ragdolls that fall into a heap: they hold together, stay within their limits and come to rest.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numbers>

#include "support/joined_run.h"

namespace atl::test {
namespace {

class RagdollsTest : public testing::TestWithParam<JointSolver> {};

// One by one, joints give way in the step of an impact, and are back within some steps.
TEST_P(RagdollsTest, HoldTogetherAndComeToRest) {
  constexpr double degree = std::numbers::pi / 180;
  constexpr int dolls = 20, parts = 13;
  const bool direct = GetParam() == JointSolver::Direct;
  // How each heap falls is chance, so what it comes to is the mean of several.
  constexpr std::uint64_t seeds = 8;
  double mean_gap_where_stopped = 0, mean_gap_at_end = 0, mean_excess_at_end = 0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    JoinedRun run(load_scene("ragdolls:count=20", seed), GetParam());
    double gap = 0, gap_where_stopped = 0, excess = 0, gap_at_end = 0, excess_at_end = 0;
    std::int64_t asleep = 0;
    for (int step = 0; step < run.scene.steps; ++step) {
      const StepReport report = run.world.step(run.scene.dt);
      ASSERT_EQ(report.first_quarantined, -1) << step;
      asleep = report.counts.asleep;
      const JointDriftReport drift = run.drift();
      // Limbs that are put back within a step open their joints by the square of how far they turned in it.
      double& max = report.counts.stopped > 0 ? gap_where_stopped : gap;
      max = std::max(max, gap_at_end = drift.max);
      excess = std::max(excess, excess_at_end = drift.angle_excess_max);
    }
    EXPECT_LT(gap, direct ? 0.005 : 0.1) << seed;
    EXPECT_LT(excess, (direct ? 1 : 60) * degree) << seed;
    EXPECT_EQ(asleep, dolls * parts) << seed;
    mean_gap_where_stopped += gap_where_stopped / seeds;
    mean_gap_at_end += gap_at_end / seeds;
    mean_excess_at_end += excess_at_end / seeds;
  }
  EXPECT_LT(mean_gap_where_stopped, direct ? 0.01 : 0.1);
  EXPECT_LT(mean_gap_at_end, direct ? 1e-6 : 0.004);
  EXPECT_LT(mean_excess_at_end, (direct ? 1e-3 : 2) * degree);
}

INSTANTIATE_TEST_SUITE_P(Solvers, RagdollsTest, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

}  // namespace
}  // namespace atl::test
