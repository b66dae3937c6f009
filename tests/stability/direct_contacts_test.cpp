// Columns that sweeps can't hold up, at default settings: they stand, carry what they should, and what moves among them
// keeps its momentum and energy.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "support/scene_run.h"
#include "support/scenes.h"

namespace atl::test {
namespace {

struct Column {
  const char* scene;
  double sink;  ///< m, allowed
};

class ColumnTest : public testing::TestWithParam<Column> {};

TEST_P(ColumnTest, StandsForTenSeconds) {
  SceneRun run(GetParam().scene);
  double penetration = 0;
  for (int step = 0; step < run.scene.steps; ++step) {
    ASSERT_EQ(run.world.step(run.scene.dt).counts.direct_islands, 1) << step;
    if (step % 60 == 0) penetration = std::max(penetration, run.penetration().max);
  }
  penetration = std::max(penetration, run.penetration().max);
  const RestReport rest = run.rest();
  EXPECT_LT(penetration, 1e-3);
  EXPECT_LT(rest.drift_max, 1e-3);
  EXPECT_LT(rest.sink_max, GetParam().sink);
  for (const BodyId id : dynamic_bodies(run.world, run.ids)) {
    EXPECT_LT(run.world.velocity(id).norm(), 1e-6);
    EXPECT_LT(run.world.angular_velocity(id).norm(), 1e-6);
  }
}

// Sinks by 5 compliance g dt^2 and contact, times the ratio of what is carried to what carries.
INSTANTIATE_TEST_SUITE_P(Columns, ColumnTest,
                         testing::Values(Column{"stack:height=15", 1e-4}, Column{"stack:height=50", 1e-4},
                                         Column{"stack:height=100", 1e-4}, Column{"stack:height=10,ratio=10", 1e-4},
                                         Column{"stack:height=10,ratio=1000", 1e-4},
                                         Column{"stack:height=10,ratio=10000", 1e-4},
                                         Column{"stack:height=10,ratio=100000", 1e-3},
                                         Column{"stack:height=10,ratio=1000000", 5e-3}),
                         [](const auto& column) { return case_name(column.param.scene); });

// Each box 2.15 times as heavy as the one under it.
TEST(DirectContacts, LadderOfMassesStands) {
  World world;
  world.add_body(ground());
  std::vector<BodyId> ids;
  for (int i = 0; i < 10; ++i) {
    BodyDef def = box({0, 0, 0.5 + i});
    def.mass = std::pow(1000.0, i / 9.0);
    ids.push_back(world.add_body(def));
  }
  run_finite(world, 600);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_NEAR(world.pose(ids[i]).position.z(), 0.5 + static_cast<double>(i), 1e-4);
    EXPECT_LT(world.pose(ids[i]).position.head<2>().norm(), 1e-3);
  }
}

// A contact reports the weight of all above it.
TEST(DirectContacts, ForcesAreTheWeightsAbove) {
  World world;
  world.add_body(ground());
  const std::vector<BodyId> ids = add_stack(world, 30);
  run(world, 120);
  ASSERT_EQ(world.step(dt).counts.direct_islands, 1);
  const double weight = world.mass(ids[0]) * g;
  std::vector<double> carried(ids.size(), 0.0);
  for (const ContactForce& force : world.contact_forces()) {
    const auto above = std::find(ids.begin(), ids.end(), force.b);
    ASSERT_NE(above, ids.end());
    carried[static_cast<std::size_t>(above - ids.begin())] += force.normal_force;
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_NEAR(carried[i], weight * static_cast<double>(ids.size() - i), 1e-3 * weight) << i;
  }
}

// A heavy box falls on a column of light ones: it stays up, and nothing gains energy.
TEST(DirectContacts, ColumnSurvivesWhatIsDroppedOnIt) {
  World world;
  world.add_body(ground());
  std::vector<BodyId> ids = add_stack(world, 9);
  BodyDef heavy = box({0, 0, 10});
  heavy.density = 1000 * heavy.density;
  ids.push_back(world.add_body(heavy));
  const auto energy = [&] {
    double sum = kinetic_energy(world, ids);
    for (const BodyId id : ids) sum += world.mass(id) * g * world.pose(id).position.z();
    return sum;
  };
  const double at_start = energy();
  for (int step = 0; step < 600; ++step) {
    ASSERT_EQ(world.step(dt).first_quarantined, -1);
    ASSERT_LT(energy(), at_start * (1 + 1e-4)) << step;
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_NEAR(world.pose(ids[i]).position.z(), 0.5 + static_cast<double>(i), 2e-3) << i;
    EXPECT_LT(world.pose(ids[i]).position.head<2>().norm(), 0.1) << i;
  }
}

// Columns on a tilted plane: they slide as one where friction lets them, as fast as a block does.
TEST(DirectContacts, ColumnSlidesAsABlock) {
  constexpr double slope = 0.2, mu = 0.1;
  World world({.gravity = g * Vector3(std::sin(slope), 0, -std::cos(slope))});
  world.add_body(ground(mu));
  std::vector<BodyId> ids;
  for (int i = 0; i < 20; ++i) {
    BodyDef def = box({0, 0, 0.05 + 0.1 * i}, {0.5, 0.5, 0.05});
    def.material.friction = i == 0 ? mu : 2;
    ids.push_back(world.add_body(def));
  }
  world.step(dt);
  int direct = 0;
  for (int step = 1; step < 120; ++step) direct += static_cast<int>(world.step(dt).counts.direct_islands);
  EXPECT_GT(direct, 100);
  // Friction of a pair is the geometric mean of what its two say.
  const double expected = g * (std::sin(slope) - mu * std::cos(slope)) * 2;
  for (const BodyId id : ids) EXPECT_NEAR(world.velocity(id).x(), expected, 2e-3 * expected);
}

// Without gravity nothing but contacts acts: a light box between heavy ones that meet.
TEST(DirectContacts, ConservesMomentum) {
  World world({.gravity = Vector3::Zero(), .settings = {.contact_solver = ContactSolver::Direct}});
  std::vector<BodyId> ids;
  for (int i = 0; i < 3; ++i) {
    BodyDef def = box({0.02 * i, 0.01 * i, 1.001 * i});
    def.mass = i == 1 ? 1 : 1000;
    def.velocity = {0.1 * i, 0, i == 0 ? 1.0 : i == 2 ? -1.0 : 0.0};
    ids.push_back(world.add_body(def));
  }
  const Vector3 before = momentum(world, ids);
  std::int64_t direct = 0;
  for (int step = 0; step < 60; ++step) direct += world.step(dt).counts.direct_islands;
  EXPECT_GT(direct, 0);
  EXPECT_LT((momentum(world, ids) - before).norm(), 1e-10 * 1000);
}

TEST(DirectContacts, TellWhichIslandsTheyAre) {
  World world;
  world.add_body(ground());
  const std::vector<BodyId> low = add_stack(world, 4, {10, 0, 0});
  const std::vector<BodyId> high = add_stack(world, 20);
  const StepReport report = world.step(dt);
  ASSERT_EQ(world.solver_choices().size(), 1u);
  const SolverChoice& island = world.solver_choices().front();
  EXPECT_EQ(island.lowest.index, high.front().index);
  EXPECT_EQ(island.bodies, 20u);
  EXPECT_EQ(island.contacts, 20u);
  EXPECT_TRUE(island.direct);
  EXPECT_FALSE(island.gave_up);
  EXPECT_STREQ(island.why, "contacts give way under what they carry");
  EXPECT_EQ(report.counts.direct_islands, 1);
  EXPECT_EQ(report.counts.refined_islands, 0);
  world.set_settings({.contact_solver = ContactSolver::Iterative});
  EXPECT_EQ(world.step(dt).counts.direct_islands, 0);
  EXPECT_TRUE(world.solver_choices().empty());
}

// A box that lands hard loads what it lands on for a step: nothing to be done about.
TEST(DirectContacts, ImpactsAreNoLoads) {
  World world;
  world.add_body(ground());
  add_stack(world, 3);
  world.add_body(box({0, 0, 8}));
  for (int step = 0; step < 300; ++step) EXPECT_EQ(world.step(dt).counts.direct_islands, 0) << step;
}

// The wall of a hundred rows, of which sweeps alone let the top sink by 0.7 m.
TEST(RefinedSubsteps, HoldAWallUp) {
  SceneRun run("wall:base=100");
  for (int step = 0; step < 240; ++step) {
    ASSERT_EQ(run.world.step(run.scene.dt).counts.refined_islands, 1) << step;
  }
  EXPECT_LT(run.rest().sink_max, 0.1);
  EXPECT_LT(run.penetration().max, 2e-3);
}

// With a frequency of their own soft contacts give by what lies on them; left to themselves they stiffen.
// Which contact of a pile is the worst is chance: over three of them.
TEST(Stiffening, LoadedContactsOverlapByHalf) {
  PenetrationReport stiff, soft;  // sums
  const auto add_overlap = [](const char* scene, std::optional<double> contact_hertz, PenetrationReport& sum) {
    SceneRun run(scene);
    Settings settings = run.scene.settings;
    settings.contact_hertz = contact_hertz;
    run.world.set_settings(settings);
    for (int step = 0; step < 240; ++step) run.world.step(run.scene.dt);
    sum.p99 += run.penetration().p99;
    sum.mean += run.penetration().mean;
  };
  constexpr double standard = 30;  // Hz, of four substeps
  for (const char* scene : {"pile:bodies=1400", "pile:bodies=1500", "pile:bodies=1600"}) {
    add_overlap(scene, std::nullopt, stiff);
    add_overlap(scene, standard, soft);
  }
  EXPECT_LT(stiff.p99, 0.5 * soft.p99);
  EXPECT_LT(stiff.mean, 0.8 * soft.mean);
}

// Stacks that slide go as far as their friction lets them, v^2 / (2 mu g), wherever they are solved at once.
TEST(DirectContacts, KeepToTheConeOfFriction) {
  constexpr double gravity = 9.81, speed = 4;  // m/s^2, m/s
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (const int substeps : {1, 4}) {
      for (const double friction : {0.1, 0.2, 0.3, 0.6}) {
        World world({.settings = {.substeps = substeps, .contact_solver = solver}});
        const Material material{.friction = friction};
        world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = material});
        BodyId low = {};
        for (int i = 0; i < 2; ++i) {
          const BodyId body = world.add_body({.shape = Box{{0.4, 0.4, 0.1}},
                                              .position = {0, 0, 0.1 + 0.2 * i},
                                              .velocity = speed * Vector3(std::cos(0.7), std::sin(0.7), 0),
                                              .material = material});
          if (i == 0) low = body;
        }
        double before = speed;
        const double slows = friction * gravity * dt;  // m/s a step
        for (int i = 0; i < 60; ++i) {
          world.step(dt);
          const double now = world.velocity(low).head<2>().norm();
          EXPECT_LT(before - now, 1.1 * slows + 0.02) << "mu " << friction << " x " << substeps << " step " << i;
          before = now;
        }
        const double time = std::min(1.0, speed / (friction * gravity));
        const double right = speed * time - 0.5 * friction * gravity * time * time;
        EXPECT_NEAR(world.pose(low).position.head<2>().norm(), right, 0.02 * right) << friction << " x " << substeps;
      }
    }
  }
}

}  // namespace
}  // namespace atl::test
