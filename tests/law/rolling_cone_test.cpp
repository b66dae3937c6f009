// A cone that rolls about its apex on a plane: an axis that turns takes the line of the contact along, and gains
// nothing.

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"
#include "support/min_turn.h"

namespace atl::test {
namespace {

// rad/s about the vertical, after a turn that starts with 2.
double rate_after_a_turn(ContactSolver solver, double radius, double half_height, double step) {
  World world({.settings = {.contact_solver = solver}});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = 5}});
  // It lies along x with its apex at the origin, and turns about the line in which it touches.
  constexpr double rate = 2;
  const double lean = std::atan(radius / (2 * half_height));
  const Vector3 axis(std::cos(lean), 0, std::sin(lean));
  const Vector3 spin(-rate / std::tan(lean), 0, 0);
  const BodyId cone = world.add_body({.shape = Cone{radius, half_height},
                                      .position = half_height * axis,
                                      .orientation = min_turn(Vector3::UnitZ(), -axis),
                                      .velocity = spin.cross(1.5 * half_height * axis),
                                      .angular_velocity = spin,
                                      .material = {.friction = 5}});
  for (double time = 0; time < 2 * M_PI / rate; time += step) world.step(step);
  return world.angular_velocity(cone).norm() * std::tan(lean);
}

TEST(RollingCone, GainsNoSpeed) {
  for (const ContactSolver solver : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double radius : {0.3, 0.6}) {
      const double coarse = rate_after_a_turn(solver, radius, 0.4, 1.0 / 60);
      const double fine = rate_after_a_turn(solver, radius, 0.4, 1.0 / 240);
      EXPECT_LT(coarse, 2.002) << radius;
      EXPECT_GT(coarse, 1.8) << radius;
      EXPECT_LT(fine, 2.002) << radius;
      EXPECT_GT(fine, 1.95) << radius;
    }
    // A slender one rolls by 0.18 rad a step: it gains 3% with sweeps, and loses 9% at once.
    EXPECT_NEAR(rate_after_a_turn(solver, 0.15, 0.4, 1.0 / 60), 2, 0.2);
    EXPECT_NEAR(rate_after_a_turn(solver, 0.15, 0.4, 1.0 / 240), 2, 0.06);
  }
}

}  // namespace
}  // namespace atl::test
