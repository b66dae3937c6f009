// The contact problem that a step hands out is that of the bodies and contacts in the world.

#include <atoll/atoll.h>
#include <atoll/errors.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "reference/reference_solver.h"
#include "support/bodies.h"
#include "support/scene_run.h"

namespace atl::contact_problem_test {
namespace {

constexpr Settings keeping{.keep_contact_problem = true};

ContactProblem problem_after(const std::string& scene, int steps) {
  test::SceneRun run(scene, {.settings = keeping});
  test::run(run.world, steps);
  return run.world.contact_problem();
}

TEST(ContactProblem, IsEmptyWithoutTheSetting) {
  test::SceneRun run("stack");
  run.world.step(test::dt);
  EXPECT_TRUE(run.world.contact_problem().patches.empty());
}

TEST(ContactProblem, HoldsTheSubstepAndTheBodiesOfAStack) {
  const ContactProblem problem = problem_after("stack:height=3", 200);
  EXPECT_NEAR(problem.substep, test::substep(), 1e-9);
  ASSERT_EQ(problem.bodies.size(), 3u);
  ASSERT_EQ(problem.patches.size(), 3u);
  for (const ContactProblem::Body& body : problem.bodies) {
    EXPECT_NEAR(body.inverse_mass, 1e-3, 1e-9);
    EXPECT_NEAR((body.inverse_inertia * (1000.0 / 6) - Matrix3::Identity()).norm(), 0, 1e-6);
    // At rest before the forces: gravity's velocity change of a substep.
    EXPECT_NEAR((body.free_velocity - Vector3(0, 0, -test::g * problem.substep)).norm(), 0, 2e-4);
  }
  for (const ContactProblem::Patch& patch : problem.patches) EXPECT_EQ(patch.points.size(), 4u);
}

TEST(ContactProblem, FramesAreOrthonormalInDouble) {
  const ContactProblem problem = problem_after("pile:bodies=50", 60);
  ASSERT_GT(problem.patches.size(), 20u);
  for (const ContactProblem::Patch& patch : problem.patches) {
    EXPECT_NEAR(patch.normal.norm(), 1, 1e-15);
    EXPECT_NEAR(patch.tangent.norm(), 1, 1e-15);
    EXPECT_NEAR(patch.normal.dot(patch.tangent), 0, 1e-15);
    EXPECT_NEAR(patch.normal.dot(patch.friction_impulse), 0, 1e-15 * (1 + patch.friction_impulse.norm()));
  }
}

// Each impulse carries what lies above it.
TEST(ContactProblem, ImpulsesCarryTheWeightOfAStack) {
  const ContactProblem problem = problem_after("stack:height=3", 200);
  std::vector<double> loads;
  for (const ContactProblem::Patch& patch : problem.patches) {
    double sum = 0;
    for (const ContactProblem::Point& point : patch.points) sum += point.impulse;
    loads.push_back(sum / (1000 * test::g * problem.substep));
  }
  std::sort(loads.begin(), loads.end());
  ASSERT_EQ(loads.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(loads[i], static_cast<double>(i + 1), 1e-3);
}

// If nothing bounces, the velocities that follow from the captured impulses are those of the world: free velocities,
// masses, frames and impulses belong to one another.
TEST(ContactProblem, ItsVelocitiesAreThoseOfTheWorld) {
  for (const char* name : {"stack", "pyramid3d:layers=4", "pile:bodies=50", "wall:base=5"}) {
    for (const int steps : {1, 40, 90}) {
      test::SceneRun run(name, {.settings = keeping});
      test::run(run.world, steps);
      const ContactProblem problem = run.world.contact_problem();
      const std::vector<reference::BodyVelocity> velocities = reference::velocities_after(problem);
      for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
        const auto column = static_cast<Eigen::Index>(problem.bodies[i].index);
        const double speed = run.world.velocities().col(column).norm();
        EXPECT_NEAR((velocities[i].linear - run.world.velocities().col(column)).norm(), 0, 1e-5 * (1 + speed)) << name;
        EXPECT_NEAR((velocities[i].angular - run.world.angular_velocities().col(column)).norm(), 0, 1e-5 * (1 + speed))
            << name;
      }
    }
  }
}

TEST(ContactProblem, HoldsWhatMovesAsItIsTold) {
  World world({.settings = keeping});
  const BodyId floor = world.add_body(
      {.type = BodyType::Kinematic, .shape = Box{{2, 2, 0.5}}, .position = {0, 0, -0.5}, .velocity = {0.5, 0, 0}});
  world.add_body(test::box({0, 0, 0.5}));
  test::run(world, 10);
  const ContactProblem problem = world.contact_problem();
  ASSERT_EQ(problem.bodies.size(), 2u);
  const auto is_floor = [&](const ContactProblem::Body& body) { return body.index == floor.index; };
  const auto body = std::find_if(problem.bodies.begin(), problem.bodies.end(), is_floor);
  ASSERT_NE(body, problem.bodies.end());
  EXPECT_EQ(body->inverse_mass, 0);
  EXPECT_EQ(body->free_velocity, Vector3(0.5, 0, 0));
}

TEST(ContactProblem, AskingForItChangesNoBit) {
  const auto hash = [](const Settings& settings) {
    test::SceneRun run("pile:bodies=30", {.settings = settings});
    test::run(run.world, 60);
    return run.world.state_hash();
  };
  EXPECT_EQ(hash({}), hash(keeping));
}

// The kernel's answer where its sweeps have little left to do: what single precision leaves.
TEST(ContactProblem, ABoxAtRestIsSolvedToSinglePrecision) {
  EXPECT_LT(measure_contact_residual(problem_after("stack:height=1", 60)).relative, 1e-5);
  EXPECT_LT(measure_contact_residual(problem_after("pyramid3d:layers=3", 300)).relative, 1e-4);
}

TEST(ContactProblem, MoreSweepsComeNearer) {
  const auto residual = [](int relax) {
    test::SceneRun run("wall:base=6", {.settings = {.relax_iterations = relax, .keep_contact_problem = true}});
    test::run(run.world, 3);
    return measure_contact_residual(run.world.contact_problem()).relative;
  };
  EXPECT_GT(residual(1), 2 * residual(8));
  EXPECT_GT(residual(8), 2 * residual(64));
}

}  // namespace
}  // namespace atl::contact_problem_test
