// Torsional friction tau brakes a spin about the normal by at most tau times the normal force.

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"

namespace atl::test::torsional_friction_test {
namespace {

constexpr double radius = 0.5;
constexpr double spin = 3;  // rad/s

/// Spin after `seconds` of a body that starts upright with `spin` about the vertical.
Vector3 spin_after(double seconds, BodyDef def, const Material& material, const Settings& settings = {}) {
  World world({.settings = settings});
  world.add_body(ground(1));
  def.angular_velocity = {0, 0, spin};
  def.material = material;
  const BodyId id = world.add_body(def);
  run(world, static_cast<int>(std::lround(seconds / dt)));
  return world.angular_velocity(id);
}

TEST(TorsionalFriction, BrakesInProportion) {
  for (const Stabilisation stabilisation :
       {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    for (const double torsion : {0.002, 0.004, 0.008}) {
      const double deceleration = torsion * g / (0.4 * radius * radius);
      const Vector3 left = spin_after(1, sphere({0, 0, radius}), {.friction = 1, .torsional_friction = torsion},
                                      {.stabilisation = stabilisation});
      EXPECT_NEAR(left.z(), spin - deceleration, 5e-3 * deceleration + 1e-4)
          << torsion << ", " << static_cast<int>(stabilisation);
      EXPECT_LT(left.head<2>().norm(), 1e-4);
    }
  }
}

TEST(TorsionalFriction, AddsToTheTorqueOfAPatchsFriction) {
  // A box on its face: what its points' friction brakes in a while, it brakes more of with torsion, by that torque.
  constexpr double torsion = 0.02, seconds = 0.2;
  const BodyDef plate = box({0, 0, 0.25}, {0.5, 0.5, 0.25});
  const double inertia_over_mass = 1.0 / 6;
  const double plain = spin_after(seconds, plate, {.friction = 0.01}).z();
  const double both = spin_after(seconds, plate, {.friction = 0.01, .torsional_friction = torsion}).z();
  ASSERT_LT(plain, 0.99 * spin) << "friction alone has a lever here";
  EXPECT_NEAR(plain - both, torsion * g / inertia_over_mass * seconds, 0.02 * torsion * g / inertia_over_mass);
}

TEST(TorsionalFriction, HasNoRollingImpulseHoweverSmallTheSpin) {
  const Scene scene = load_scene("torsion");
  World world({.gravity = scene.gravity, .settings = {.substeps = 16, .keep_contact_problem = true}});
  build_scene(scene, world);
  for (int i = 0; i < scene.steps; ++i) {
    world.step(scene.dt);
    const ContactProblem problem = world.contact_problem();
    for (const ContactProblem::Patch& patch : problem.patches) ASSERT_EQ(patch.rolling_impulse, Vector3::Zero()) << i;
    EXPECT_LT(measure_contact_residual(problem).relative, 1) << i;
  }
}

TEST(TorsionalFriction, DoesNotBrakeRolling) {
  World world;
  world.add_body(ground());
  BodyDef def = sphere({0, 0, radius}, radius);
  def.material.torsional_friction = 0.1;
  def.velocity = {2, 0, 0};
  def.angular_velocity = {0, 4, 0};
  const BodyId ball = world.add_body(def);
  run(world, 120);
  EXPECT_NEAR(world.velocity(ball).x(), 2, 2e-3);
}

}  // namespace
}  // namespace atl::test::torsional_friction_test
