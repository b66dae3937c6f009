// The reference solver against the residual, closed forms and enumeration.

#include "reference/reference_solver.h"

#include <atoll/atoll.h>
#include <atoll/errors.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <string>

#include "reference/contact_rows.h"
#include "support/bodies.h"
#include "support/random.h"
#include "support/scene_run.h"

namespace atl::reference_solver_test {
namespace {

using reference::ReferenceSolution;
using reference::solve_contact_problem;
using test::Random;

constexpr Settings keeping{.keep_contact_problem = true};

void expect_solved(const ContactProblem& problem, const std::string& what) {
  ASSERT_FALSE(problem.patches.empty()) << what;
  const ReferenceSolution solution = solve_contact_problem(problem);
  EXPECT_TRUE(solution.solved) << what;
  EXPECT_LE(measure_contact_residual(solution.problem).relative, 1e-10) << what;

  // From nothing too.
  ContactProblem cold = problem;
  for (ContactProblem::Patch& patch : cold.patches) {
    for (ContactProblem::Point& point : patch.points) point.impulse = 0;
    patch.friction_impulse.setZero();
    patch.torsional_impulse = 0;
  }
  EXPECT_LE(measure_contact_residual(solve_contact_problem(cold).problem).relative, 1e-10) << what << ", cold";
}

void expect_scene_solved(const std::string& scene, int steps, int every) {
  test::SceneRun run(scene, {.settings = keeping});
  for (int i = 1; i <= steps; ++i) {
    run.world.step(test::dt);
    if (i % every == 0) expect_solved(run.world.contact_problem(), scene + ", step " + std::to_string(i));
  }
}

TEST(ReferenceSolver, SolvesABox) { expect_scene_solved("stack:height=1", 60, 10); }
TEST(ReferenceSolver, SolvesAStackOfTen) { expect_scene_solved("stack", 120, 20); }
TEST(ReferenceSolver, SolvesAStackOfFifty) { expect_scene_solved("stack:height=50", 60, 20); }
TEST(ReferenceSolver, SolvesAPyramid) { expect_scene_solved("pyramid3d:layers=4", 60, 20); }
TEST(ReferenceSolver, SolvesAPileAsItLandsAndAfter) { expect_scene_solved("pile:bodies=50", 180, 30); }
TEST(ReferenceSolver, SolvesAMassRatioOfAThousand) { expect_scene_solved("stack:height=4,ratio=1000", 40, 20); }

TEST(ReferenceSolver, SolvesSlidingAndSpinningBlocksAndSpheres) {
  World world({.settings = keeping});
  world.add_body(test::ground());
  for (int i = 0; i < 5; ++i) {
    BodyDef block = test::box({3.0 * i, 0, 0.5});
    block.velocity = {0, 2.0 * i, 0};
    block.angular_velocity = {0, 0, 3.0 - i};
    world.add_body(block);
    BodyDef ball = test::sphere({3.0 * i, 5, 0.5});
    ball.velocity = {1, 0.5 * i, 0};
    ball.angular_velocity = {0, 0, 2};
    world.add_body(ball);
  }
  for (int i = 0; i < 5; ++i) {
    test::run(world, 4);
    expect_solved(world.contact_problem(), "step " + std::to_string(4 * i + 4));
  }
}

// A block on the ground slides: its deceleration is mu g, whatever the shares of its points.
TEST(ReferenceSolver, ABlockSlidesByCoulombsLaw) {
  World world({.settings = keeping});
  world.add_body(test::ground());
  BodyDef block = test::box({0, 0, 0.5});
  block.velocity = {0, 3, 0};
  world.add_body(block);
  test::run(world, 5);
  const ContactProblem problem = world.contact_problem();
  const ReferenceSolution solution = solve_contact_problem(problem);
  ASSERT_TRUE(solution.solved);
  const Vector3 before = problem.bodies[0].free_velocity;
  const Vector3 after = reference::velocities_after(solution.problem)[0].linear;
  // Up by what stops the fall; back by mu of that, along the motion but for what the solver had it yaw.
  EXPECT_NEAR((before - after).head<2>().norm(), 0.6 * (after.z() - before.z()), 1e-9);
  EXPECT_NEAR(after.x(), before.x(), 1e-4);
}

/// The least-energy velocities without friction: min 1/2 r^T W r + b^T r over r >= 0, by trying every set of points.
Eigen::VectorXd enumerate(const reference::ContactRows& rows) {
  Eigen::MatrixXd w(rows.rows, rows.rows);
  const Eigen::VectorXd b = rows.relative_velocities(rows.free);
  for (int i = 0; i < rows.rows; ++i) {
    w.col(i) = rows.relative_velocities(rows.velocities(Eigen::VectorXd::Unit(rows.rows, i))) - b;
  }
  Eigen::VectorXd best;
  double min = std::numeric_limits<double>::infinity();
  for (int set = 0; set < 1 << rows.rows; ++set) {
    std::vector<int> active;
    for (int i = 0; i < rows.rows; ++i) {
      if (set >> i & 1) active.push_back(i);
    }
    Eigen::VectorXd r = Eigen::VectorXd::Zero(rows.rows);
    if (!active.empty()) {
      const Eigen::MatrixXd w_active = w(active, active);
      const Eigen::VectorXd b_active = b(active);
      const Eigen::VectorXd r_active = w_active.ldlt().solve(-b_active);
      r(active) = r_active;
    }
    const Eigen::VectorXd u = w * r + b;
    const double violation = std::max({0.0, -r.minCoeff(), -u.minCoeff()});
    if (violation < 1e-9 && 0.5 * r.dot(w * r) + b.dot(r) < min) {
      min = 0.5 * r.dot(w * r) + b.dot(r);
      best = rows.velocities(r);
    }
  }
  return best;
}

/// Three bodies with up to four points at each of three patches, in all directions.
ContactProblem random_problem(Random& random, double friction, bool single_points = false) {
  ContactProblem problem;
  problem.substep = 0.01;
  for (std::size_t i = 0; i < 3; ++i) {
    const Matrix3 turn = random.rotation().toRotationMatrix();
    const Vector3 moments(random.real(1, 2), random.real(1, 2), random.real(1, 2));
    problem.bodies.push_back({.index = i,
                              .inverse_mass = random.magnitude(0.2, 5),
                              .inverse_inertia = turn * moments.asDiagonal() * turn.transpose(),
                              .free_velocity = random.vector(1) - Vector3(0, 0, 1),
                              .free_angular_velocity = random.vector(0.5)});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    // Normals within a half-space, so that impulses along them don't lock the bodies.
    const Vector3 normal = (Vector3(0, 0, 1) + random.vector(0.5)).normalized();
    ContactProblem::Patch patch{.first = i == 0 ? ContactProblem::fixed : i - 1,
                                .second = i,
                                .normal = normal,
                                .tangent = normal.cross(random.direction()).normalized(),
                                .anchor_first = random.vector(0.5),
                                .anchor_second = random.vector(0.5),
                                .friction = friction,
                                .radius = friction > 0 && !single_points ? 0.3 : 0};
    const std::uint32_t points = single_points ? 1 : 2 + random.below(3);
    for (std::uint32_t k = 0; k < points; ++k) {
      patch.points.push_back(
          {.x = random.real(-0.5, 0.5), .y = random.real(-0.5, 0.5), .gap = random.real(-0.002, 0.002)});
    }
    problem.patches.push_back(patch);
  }
  return problem;
}

TEST(ReferenceSolver, FindsTheVelocitiesOfEnumerationWithoutFriction) {
  Random random(11);
  int moved = 0;
  for (int i = 0; i < 20; ++i) {
    const ContactProblem problem = random_problem(random, 0);
    const Eigen::VectorXd expected = enumerate(reference::ContactRows(problem));
    ASSERT_EQ(expected.size(), 18);
    const ReferenceSolution solution = solve_contact_problem(problem, 1e-12);
    ASSERT_TRUE(solution.solved);
    const std::vector<reference::BodyVelocity> found = reference::velocities_after(solution.problem);
    for (int k = 0; k < 3; ++k) {
      const auto body = static_cast<std::size_t>(k);
      EXPECT_NEAR((found[body].linear - expected.segment<3>(6 * k)).norm(), 0, 1e-9);
      EXPECT_NEAR((found[body].angular - expected.segment<3>(6 * k + 3)).norm(), 0, 1e-9);
    }
    moved += reference::energy_distance(problem, found, reference::free_velocities(problem)) > 0.1;
  }
  EXPECT_GT(moved, 10);
}

TEST(ReferenceSolver, SolvesRandomProblemsWithFriction) {
  Random random(12);
  for (int i = 0; i < 200; ++i) {
    const ContactProblem problem = random_problem(random, random.magnitude(0.05, 1), random.chance(0.5));
    const ReferenceSolution solution = solve_contact_problem(problem);
    EXPECT_TRUE(solution.solved) << i << ": " << solution.residual;
  }
}

// The residual knows solutions from what is none: any change of the impulses that changes velocities shows.
TEST(ReferenceSolver, AnyOtherImpulsesHaveALargerResidual) {
  Random random(13);
  for (int i = 0; i < 100; ++i) {
    const ReferenceSolution solution = solve_contact_problem(random_problem(random, 0.4));
    ASSERT_TRUE(solution.solved);
    ContactProblem other = solution.problem;
    ContactProblem::Patch& patch = other.patches[random.below(3)];
    patch.points[random.below(static_cast<std::uint32_t>(patch.points.size()))].impulse += random.magnitude(1e-4, 1);
    EXPECT_GT(measure_contact_residual(other).relative, 1e3 * solution.residual);
    EXPECT_GT(measure_contact_residual(other).absolute, 1e-7);
    EXPECT_GT(reference::velocity_error(other, solution), 0);
  }
}

TEST(ReferenceSolver, VelocitiesTurnWithTheWorld) {
  Random random(14);
  for (int i = 0; i < 20; ++i) {
    const ContactProblem problem = random_problem(random, 0.3, true);
    const Matrix3 turn = random.rotation().toRotationMatrix();
    ContactProblem turned = problem;
    for (ContactProblem::Body& body : turned.bodies) {
      body.inverse_inertia = turn * body.inverse_inertia * turn.transpose();
      body.free_velocity = turn * body.free_velocity;
      body.free_angular_velocity = turn * body.free_angular_velocity;
    }
    for (ContactProblem::Patch& patch : turned.patches) {
      for (Vector3* v : {&patch.normal, &patch.tangent, &patch.anchor_first, &patch.anchor_second}) *v = turn * *v;
    }
    const auto expected = reference::velocities_after(solve_contact_problem(problem, 1e-12).problem);
    const auto found = reference::velocities_after(solve_contact_problem(turned, 1e-12).problem);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR((found[k].linear - turn * expected[k].linear).norm(), 0, 1e-8);
  }
}

TEST(ReferenceSolver, AtASolutionThereIsNoVelocityErrorAndNothingToDo) {
  Random random(15);
  const ReferenceSolution solution = solve_contact_problem(random_problem(random, 0.4));
  EXPECT_EQ(reference::velocity_error(solution.problem, solution), 0);
  EXPECT_EQ(solve_contact_problem(solution.problem).sweeps, 0);
}

}  // namespace
}  // namespace atl::reference_solver_test
