// Islands are solved at once where that gets somewhere. Iterations that are thrown away, because the island is swept in
// the end, stay a small part of the work.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

// Work in sweeps over one contact: a Newton iteration makes and factors a matrix, which is that of at least 5.
struct Work {
  double discarded = 0, swept = 0;

  void add(const World& world, const StepReport& report) {
    constexpr double sweeps_of_iteration = 5;
    for (const SolverChoice& island : world.solver_choices()) {
      if (!island.gave_up) continue;
      discarded += sweeps_of_iteration * (1 + island.iterations) * static_cast<double>(island.contacts);
    }
    const Settings& settings = world.settings();
    swept += static_cast<double>(report.counts.contacts * settings.substeps *
                                 (settings.iterations + settings.relax_iterations));
  }
};

// Towers of 12 boxes on four plates that shake up, down and sideways: they lean on each other, and fall.
TEST(DiscardedWork, IsSmallInShakenHeaps) {
  World world;
  world.add_body(static_box({0, 0, -1}, {20, 20, 1}));
  std::vector<BodyId> plates;
  for (int p = 0; p < 4; ++p) {
    plates.push_back(world.add_body(
        {.type = BodyType::Kinematic, .shape = Box{{0.98, 4, 0.2}}, .position = {2.0 * (p - 2), 0, 0.5}}));
  }
  for (int i = 0; i < 240; ++i) {
    world.add_body(box({(i % 4 - 2) * 1.6, (i / 4 % 5 - 2) * 1.4, 1.3 + i / 20 * 1.1}, Vector3::Constant(0.4)));
  }
  Work work;
  std::int64_t discarded = 0;
  for (int step = 0; step < 300; ++step) {
    for (std::size_t p = 0; p < plates.size(); ++p) {
      const double phase = 0.3 * static_cast<double>(p);
      world.set_velocity(plates[p], {0, 0.5 * std::sin(0.05 * step + phase), 0.5 * std::cos(0.1 * step + phase)},
                         Vector3::Zero());
    }
    const StepReport report = world.step(dt);
    work.add(world, report);
    discarded += report.counts.discarded_iterations;
    EXPECT_LE(report.counts.discarded_iterations, report.counts.newton_iterations);
  }
  EXPECT_LT(work.discarded, 0.05 * work.swept) << discarded << " iterations";
}

// Loose rows of boxes, layer over layer, that fall and meet.
TEST(DiscardedWork, IsSmallInHeapsThatFallAndMeet) {
  World world;
  world.add_body(ground());
  for (int i = 0; i < 300; ++i) {
    const double x = (i % 5 - 2) * 1.2 + 0.3 * std::sin(1.7 * i), y = (i / 5 % 5 - 2) * 1.2 + 0.3 * std::cos(2.3 * i);
    world.add_body(box({x, y, 1 + i / 25 * 1.5}, Vector3::Constant(0.4)));
  }
  Work work;
  for (int step = 0; step < 300; ++step) work.add(world, world.step(dt));
  EXPECT_LT(work.discarded, 0.05 * work.swept);
}

// Walls stand, so they are solved.
TEST(DiscardedWork, IsNoneInWallsThatAreToBeSolvedAtOnce) {
  for (const char* const scene : {"wall:base=4", "islands:count=4,base=6", "islands:count=4,base=10"}) {
    SceneRun run(scene, {.settings = {.contact_solver = ContactSolver::Direct}});
    std::int64_t unsolved = 0;
    for (int step = 0; step < 120; ++step) {
      const StepReport report = run.world.step(run.scene.dt);
      unsolved += report.counts.unsolved_islands;
      EXPECT_EQ(report.counts.refused_islands, 0);
    }
    EXPECT_EQ(unsolved, 0) << scene;
    EXPECT_LT(run.rest().drift_max, 1e-3) << scene;
  }
}

// Too large for one factor: it is swept, and that is told.
TEST(DiscardedWork, LargeIslandsAreRefusedAndTold) {
  SceneRun run("pyramid3d:layers=8", {.settings = {.contact_solver = ContactSolver::Direct}});
  const StepReport report = run.world.step(run.scene.dt);
  EXPECT_EQ(report.counts.refused_islands, 1);
  EXPECT_EQ(report.counts.unsolved_islands, 0);
  EXPECT_EQ(report.counts.newton_iterations, 0);
  ASSERT_EQ(run.world.solver_choices().size(), 1u);
  const SolverChoice& island = run.world.solver_choices().front();
  EXPECT_FALSE(island.direct);
  EXPECT_FALSE(island.gave_up);
  EXPECT_EQ(island.bodies, 204u);
  EXPECT_STREQ(island.why_not, "its factor would be too large");
}

}  // namespace
}  // namespace atl::test
