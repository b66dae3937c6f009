// The contact residual against solutions made by hand, a number worked out on paper, and the symmetries of mechanics.

#include <atoll/error.h>
#include <atoll/errors.h>
#include <audit/friction_cone.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "support/expect_error.h"
#include "support/random.h"

namespace atl {
namespace {

using audit::FrictionBounds;
using audit::PatchVector;
using audit::project_on_cone;
using test::Random;

constexpr double h = 0.005;        // s
constexpr double mass = 2;         // kg
constexpr double fall = 9.81 * h;  // m/s
constexpr double weight = mass * fall;

/// A cube of 1 m on the ground, its four corners touching; without impulses.
ContactProblem cube_on_ground() {
  ContactProblem problem;
  problem.substep = h;
  problem.bodies.push_back(
      {.inverse_mass = 1 / mass, .inverse_inertia = Matrix3::Identity() * (6 / mass), .free_velocity = {0, 0, -fall}});
  problem.patches.push_back(
      {.second = 0,
       .normal = {0, 0, 1},
       .tangent = {1, 0, 0},
       .anchor_first = {0, 0, 0},
       .anchor_second = {0, 0, -0.5},
       .friction = 0.5,
       .radius = 0.3,
       .points = {{.x = 0.5, .y = 0.5}, {.x = 0.5, .y = -0.5}, {.x = -0.5, .y = 0.5}, {.x = -0.5, .y = -0.5}}});
  return problem;
}

void press(ContactProblem& problem, double front, double back) {
  for (ContactProblem::Point& point : problem.patches[0].points) point.impulse = point.x > 0 ? front : back;
}

ContactProblem resting_cube() {
  ContactProblem problem = cube_on_ground();
  press(problem, weight / 4, weight / 4);
  return problem;
}

/// Some bodies with contacts in all directions and impulses that solve nothing.
ContactProblem random_problem(Random& random) {
  ContactProblem problem;
  problem.substep = random.real(0.001, 0.02);
  for (std::size_t i = 0; i < 3; ++i) {
    const Matrix3 turn = random.rotation().toRotationMatrix();
    const Vector3 moments(random.real(1, 2), random.real(1, 2), random.real(1, 2));
    problem.bodies.push_back({.index = i,
                              .inverse_mass = random.magnitude(0.1, 10),
                              .inverse_inertia = turn * moments.asDiagonal() * turn.transpose(),
                              .free_velocity = random.vector(1),
                              .free_angular_velocity = random.vector(1)});
  }
  const std::size_t fixed = ContactProblem::fixed;
  for (const auto& [first, second] : {std::pair{fixed, std::size_t{0}},
                                      {std::size_t{0}, std::size_t{1}},
                                      {std::size_t{1}, std::size_t{2}},
                                      {std::size_t{2}, std::size_t{0}}}) {
    const Vector3 normal = random.direction();
    ContactProblem::Patch patch{.first = first,
                                .second = second,
                                .normal = normal,
                                .tangent = normal.cross(random.direction()).normalized(),
                                .anchor_first = random.vector(1),
                                .anchor_second = random.vector(1),
                                .friction = random.real(0.1, 1),
                                .radius = random.real(0.1, 1)};
    const std::uint32_t points = 1 + random.below(4);
    for (std::uint32_t i = 0; i < points; ++i) {
      patch.points.push_back({.x = random.real(-1, 1),
                              .y = random.real(-1, 1),
                              .gap = random.real(-0.01, 0.01),
                              .impulse = random.real(0, 1)});
    }
    patch.friction_impulse = 0.3 * normal.cross(random.vector(1));
    patch.torsional_impulse = random.real(-0.2, 0.2);
    problem.patches.push_back(patch);
  }
  problem.bodies[0].free_velocity -= 10 * problem.patches[0].normal;  // one closes at least
  return problem;
}

// At solutions.

TEST(ContactResidual, ACubeAtRestOnFourPointsIsASolution) {
  EXPECT_LT(measure_contact_residual(resting_cube()).relative, 1e-12);
}

// Friction acts below the centre of mass, so the front carries more: the moment about y is 1/2 mu N - 1/2 (F - B) = 0.
TEST(ContactResidual, ACubeThatSlidesWithFrictionAgainstItIsASolution) {
  ContactProblem problem = cube_on_ground();
  problem.bodies[0].free_velocity.x() = 1;
  press(problem, 1.5 * weight / 4, 0.5 * weight / 4);
  problem.patches[0].friction_impulse = {-0.5 * weight, 0, 0};
  EXPECT_LT(measure_contact_residual(problem).relative, 1e-12);

  problem.patches[0].friction_impulse *= 0.9;  // slides, but not on the cone's boundary
  EXPECT_GT(measure_contact_residual(problem).absolute, 1e-3);
}

TEST(ContactResidual, ACubeThatTwistsWithFrictionAgainstItIsASolution) {
  ContactProblem problem = resting_cube();
  problem.bodies[0].free_angular_velocity.z() = 1;
  problem.patches[0].torsional_impulse = -0.5 * 0.3 * weight;
  EXPECT_LT(measure_contact_residual(problem).relative, 1e-12);

  problem.patches[0].torsional_impulse *= -1;
  EXPECT_GT(measure_contact_residual(problem).absolute, 1e-3);
}

TEST(ContactResidual, FrictionThatStopsACubeWithinTheConeIsASolution) {
  ContactProblem problem = cube_on_ground();
  const double speed = 0.2 * fall;
  problem.bodies[0].free_velocity.x() = speed;
  press(problem, 1.2 * weight / 4, 0.8 * weight / 4);
  problem.patches[0].friction_impulse = {-mass * speed, 0, 0};
  EXPECT_LT(measure_contact_residual(problem).relative, 1e-12);
}

TEST(ContactResidual, ACubeThatLeavesNeedsNoImpulse) {
  ContactProblem problem = cube_on_ground();
  problem.bodies[0].free_velocity = {1, 0, 0.1};
  EXPECT_EQ(measure_contact_residual(problem).absolute, 0);
  EXPECT_EQ(measure_contact_residual(problem).relative, 0);
}

TEST(ContactResidual, ACubeMayCloseItsGapAndNoMore) {
  ContactProblem problem = cube_on_ground();
  for (ContactProblem::Point& point : problem.patches[0].points) point.gap = fall * h;
  EXPECT_LT(measure_contact_residual(problem).absolute, 1e-15);
  for (ContactProblem::Point& point : problem.patches[0].points) point.gap = 0.5 * fall * h;
  EXPECT_GT(measure_contact_residual(problem).absolute, 0.1 * fall);
  press(problem, weight / 8, weight / 8);
  EXPECT_LT(measure_contact_residual(problem).relative, 1e-12);
}

// Overlap is no business of the velocities: only what is apart may approach.
TEST(ContactResidual, OverlapCountsAsTouching) {
  ContactProblem problem = resting_cube();
  for (ContactProblem::Point& point : problem.patches[0].points) point.gap = -0.01;
  EXPECT_LT(measure_contact_residual(problem).relative, 1e-12);
}

// Away from them.

// A point mass of 2 kg comes down on a plane at (1, 0, -2) m/s, mu = 1/2, and is given 1 N s along the normal. Then
// u = (1, 0, -1.5), de Saxce's correction is 1/2, all rows have 2 kg, z = r - m u = 1 - 2 (-1.5 + 0.5) = 3 along the
// normal and -2 along x. The projection has R = 3 + mu (2 - mu R), so R = 3.2, and friction -1.6. The residual is
// |(1 - 3.2, 1.6)| / 2 kg = sqrt(7.4) / 2 m/s, against sqrt(1 + 4) m/s.
TEST(ContactResidual, IsTheNumberWorkedOutOnPaper) {
  ContactProblem problem;
  problem.substep = 0.1;
  problem.bodies.push_back({.inverse_mass = 0.5, .free_velocity = {1, 0, -2}});
  problem.patches.push_back({.second = 0,
                             .normal = {0, 0, 1},
                             .tangent = {1, 0, 0},
                             .anchor_first = {0, 0, 0},
                             .anchor_second = {0, 0, 0},
                             .friction = 0.5,
                             .points = {{.impulse = 1}}});
  const ResidualReport report = measure_contact_residual(problem);
  EXPECT_NEAR(report.absolute, std::sqrt(7.4) / 2, 1e-14);
  EXPECT_NEAR(report.relative, std::sqrt(7.4 / 5) / 2, 1e-14);
  EXPECT_EQ(report.by_patch, std::vector<double>{report.absolute});
}

TEST(ContactResidual, GrowsInProportionToASmallChangeAndNeverFalls) {
  for (const bool along_normal : {true, false}) {
    const auto residual = [&](double change) {
      ContactProblem problem = resting_cube();
      if (along_normal) {
        for (ContactProblem::Point& point : problem.patches[0].points) point.impulse += change * weight;
      } else {
        problem.patches[0].friction_impulse.y() = change * weight;
      }
      return measure_contact_residual(problem).relative;
    };
    EXPECT_GT(residual(1e-3), 1e-4);
    EXPECT_NEAR(residual(1e-3) / residual(1e-6), 1e3, 1e-3);
    double last = 0;
    for (double change = 1e-6; change < 10; change *= 2) {
      const double value = residual(change);
      EXPECT_GT(value, last) << change;
      last = value;
    }
  }
}

TEST(ContactResidual, IsTheSumOfItsPatches) {
  Random random(7);
  const ResidualReport report = measure_contact_residual(random_problem(random));
  ASSERT_EQ(report.by_patch.size(), 4u);
  double sum = 0;
  for (const double one : report.by_patch) sum += one * one;
  EXPECT_NEAR(report.absolute, std::sqrt(sum), 1e-14);
  EXPECT_EQ(report.worst, *std::max_element(report.by_patch.begin(), report.by_patch.end()));
  EXPECT_EQ(report.by_patch[report.worst_patch], report.worst);
}

TEST(ContactResidual, IsTheSameInATurnedWorld) {
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const ContactProblem problem = random_problem(random);
    const Matrix3 turn = random.rotation().toRotationMatrix();
    ContactProblem turned = problem;
    for (ContactProblem::Body& body : turned.bodies) {
      body.inverse_inertia = turn * body.inverse_inertia * turn.transpose();
      body.free_velocity = turn * body.free_velocity;
      body.free_angular_velocity = turn * body.free_angular_velocity;
    }
    for (ContactProblem::Patch& patch : turned.patches) {
      for (Vector3* v :
           {&patch.normal, &patch.tangent, &patch.anchor_first, &patch.anchor_second, &patch.friction_impulse}) {
        *v = turn * *v;
      }
    }
    const double expected = measure_contact_residual(problem).relative;
    EXPECT_GT(expected, 1e-3);
    EXPECT_NEAR(measure_contact_residual(turned).relative, expected, 1e-12 * expected);
  }
}

TEST(ContactResidual, RefusesAProblemThatIsNone) {
  const auto refused = [](const auto& change, const std::string& part) {
    ContactProblem problem = resting_cube();
    change(problem);
    test::expect_error([&] { measure_contact_residual(problem); }, {part});
  };
  refused([](ContactProblem& p) { p.substep = 0; }, "substep");
  refused([](ContactProblem& p) { p.patches[0].second = 1; }, "patch 0: found body 1");
  refused([](ContactProblem& p) { p.patches[0].points.clear(); }, "found 0 points");
  refused([](ContactProblem& p) { p.patches[0].points.resize(5); }, "found 5 points");
  refused([](ContactProblem& p) { p.patches[0].friction = -1; }, "friction");
  refused([](ContactProblem& p) { p.patches[0].radius = -1; }, "radius");
  refused(
      [](ContactProblem& p) {
        p.patches[0].radius = 0;
        p.patches[0].torsional_impulse = 1;
      },
      "torsional impulse");
  refused([](ContactProblem& p) { p.patches[0].torsional_friction = -1; }, "torsional friction");
  refused([](ContactProblem& p) { p.patches[0].rolling_friction = -1; }, "rolling friction");
  refused([](ContactProblem& p) { p.patches[0].rolling_impulse = {1, 0, 0}; }, "rolling impulse");
}

// The projection.

double dot(const PatchVector& a, const PatchVector& b) {
  double sum = a.tangential.dot(b.tangential) + a.torsional * b.torsional + a.rolling.dot(b.rolling);
  for (std::size_t i = 0; i < a.points; ++i) sum += a.normal[i] * b.normal[i];
  return sum;
}

PatchVector random_vector(Random& random) {
  PatchVector z{.points = 1 + random.below(4)};
  // Now and then rows that are equal or zero, where breakpoints coincide.
  const auto value = [&] { return random.chance(0.2) ? 0.5 * random.below(3) - 0.5 : random.real(-1, 1); };
  for (std::size_t i = 0; i < z.points; ++i) z.normal[i] = value();
  z.tangential = {value(), value()};
  z.torsional = value();
  z.rolling = {value(), value()};
  return z;
}

double sum(const PatchVector& r) {
  double sum = 0;
  for (std::size_t i = 0; i < r.points; ++i) sum += r.normal[i];
  return sum;
}

// Moreau: p is the projection of z on a closed convex cone if and only if p is in the cone, z - p in its polar, and the
// two are orthogonal. The polar cone here is {v_i + mu_T |v_T| + mu_w |v_w| + mu_r |v_r| <= 0 for all i}.
TEST(FrictionCone, ProjectionObeysMoreausDecomposition) {
  Random random(4);
  for (int i = 0; i < 100000; ++i) {
    const PatchVector z = random_vector(random);
    const auto bound = [&] { return random.chance(0.2) ? 0.5 * random.below(3) : random.magnitude(1e-2, 1e2); };
    const FrictionBounds friction = {bound(), bound(), bound()};
    const PatchVector p = project_on_cone(z, friction);
    const PatchVector rest = z - p;
    const double tolerance = 1e-13 * (1 + friction.tangential + friction.torsional + friction.rolling);
    ASSERT_LE(p.tangential.norm(), friction.tangential * sum(p) + tolerance);
    ASSERT_LE(std::abs(p.torsional), friction.torsional * sum(p) + tolerance);
    ASSERT_LE(p.rolling.norm(), friction.rolling * sum(p) + tolerance);
    const double friction_part = friction.tangential * rest.tangential.norm() +
                                 friction.torsional * std::abs(rest.torsional) + friction.rolling * rest.rolling.norm();
    for (std::size_t k = 0; k < z.points; ++k) {
      ASSERT_GE(p.normal[k], 0);
      ASSERT_LE(rest.normal[k] + friction_part, tolerance);
    }
    ASSERT_NEAR(dot(p, rest), 0, tolerance);
  }
}

}  // namespace
}  // namespace atl
