// Known traps of contact solvers of this kind: each test leaves one part of the solver out and shows the failure, and
// beside it the part that cures it.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/incline.h"
#include "support/scene_run.h"

namespace atl::test {
namespace {

RestReport rest_of_ten(const Settings& settings) {
  SceneRun stack("stack:height=10", {.settings = settings});
  run_finite(stack.world, 300);
  return stack.rest();
}

// One sweep hands a load on by one contact; cold, it starts anew in each step, and the weight of nine boxes never gets
// through to the lowest contact.
TEST(SolverTraps, AStackSinksWithOneColdSweepAndStandsWithSeveralWarmOnes) {
  for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    // A body falls by g h^2 = 2.7 mm in a substep: with less slop contacts come and go.
    Settings settings = {.substeps = 1, .warm_starting = false, .stabilisation = stabilisation, .slop = 5e-3};
    EXPECT_GT(rest_of_ten(settings).sink_max, 1.0) << static_cast<int>(stabilisation);
    settings.iterations = 10;
    settings.warm_starting = true;
    const RestReport warm = rest_of_ten(settings);
    EXPECT_LT(warm.sink_max, 0.05) << static_cast<int>(stabilisation);
    EXPECT_LT(warm.tilt_max, 0.02) << static_cast<int>(stabilisation);
    EXPECT_LT(warm.drift_max, 0.05) << static_cast<int>(stabilisation);
  }
}

// Substeps do the same for soft contacts as sweeps do, and stiffen them.
TEST(SolverTraps, AStackOfSoftContactsSinksWithOneColdSweepAndStandsWithWarmSubsteps) {
  constexpr ContactSolver sweeps = ContactSolver::Iterative;
  EXPECT_GT(rest_of_ten({.substeps = 1, .warm_starting = false, .contact_solver = sweeps}).sink_max, 1.0);
  const RestReport warm = rest_of_ten({.substeps = 4, .contact_solver = sweeps});
  EXPECT_LT(warm.sink_max, 0.05);
  EXPECT_LT(warm.tilt_max, 0.01);
  EXPECT_LT(warm.drift_max, 0.01);
}

/// A box on little balls, half a metre below its bottom, that has been nudged; its tilt after some seconds.
double tilt_on_feet(const std::vector<Vector3>& feet) {
  constexpr double foot = 0.05;
  World world;
  world.add_body(ground(1));
  Compound shape;
  shape.children.push_back({.shape = Box{{0.5, 0.5, 0.5}}});
  for (const Vector3& place : feet) shape.children.push_back({.shape = Sphere{foot}, .position = place});
  BodyDef def = {.shape = shape, .position = {0, 0, 1 + foot}, .material = {.friction = 1}};
  def.angular_velocity = {0, 0.02, 0};
  const BodyId id = world.add_body(def);
  run_finite(world, 240);
  return tilt(world, id);
}

// One point holds a force but no torque: the box is a pendulum upside down.
TEST(SolverTraps, ABoxFallsOffOnePointAndStandsOnFour) {
  EXPECT_GT(tilt_on_feet({{0, 0, -1}}), 0.5);
  EXPECT_LT(tilt_on_feet({{-0.4, -0.4, -1}, {0.4, -0.4, -1}, {-0.4, 0.4, -1}, {0.4, 0.4, -1}}), 5e-3);
}

// The same for a box on its own face: it has four points, a ball of the same size but one.
TEST(SolverTraps, ABoxOnItsFaceHasFourPoints) {
  const auto points = [](const BodyDef& def) {
    World world;
    world.add_body(ground());
    world.add_body(def);
    return run(world, 10).counts.points;
  };
  EXPECT_EQ(points(box({0, 0, 0.5})), 4);
  EXPECT_EQ(points(sphere({0, 0, 0.5})), 1);
}

// Coulomb's cone is what lets go. A coefficient that no load exhausts stands for friction that nothing clamps.
TEST(SolverTraps, UnclampedFrictionHoldsABlockThatShouldSlide) {
  constexpr double angle = std::numbers::pi / 3, friction = 0.5;
  const Vector3 flat(0.5, 0.5, 0.1);  // a cube would tip
  for (const Tilt tilt : {Tilt::Gravity, Tilt::Ground}) {
    const double expected = 0.5 * g * (std::sin(angle) - friction * std::cos(angle));
    EXPECT_NEAR(make_incline(angle, friction, tilt, flat).slide(1), expected, 1e-3 * expected);
    EXPECT_NEAR(make_incline(angle, 1e6, tilt, flat).slide(1), 0, 2e-3);
  }
}

/// Relative speed with which two boxes of 1 m that overlap by `depth` part in free space, and what is left of it.
struct Parting {
  double speed;    ///< m/s, at the end
  double overlap;  ///< m, at the end
};

Parting part(double depth, const Settings& settings, int steps = 60) {
  World world({.gravity = Vector3::Zero(), .settings = settings});
  const BodyId a = world.add_body(box({0, 0, 0})), b = world.add_body(box({1 - depth, 0, 0}));
  run_finite(world, steps);
  return {(world.velocity(b) - world.velocity(a)).x(), overlap(placed(world, a, Box{}), placed(world, b, Box{}))};
}

// The first substep asks for correction * depth / h, and nothing takes that speed back.
TEST(SolverTraps, BaumgarteAddsEnergyThatSplitImpulsesAndSoftContactsDoNot) {
  constexpr double depth = 0.25;
  for (const double correction : {0.1, 0.2, 0.4}) {
    Settings settings = {.correction = correction, .contact_push_speed = 1e3};
    const double h = substep(dt, settings);

    settings.stabilisation = Stabilisation::Baumgarte;
    const Parting thrown = part(depth, settings);
    EXPECT_NEAR(thrown.speed, correction * depth / h, 0.01 * correction * depth / h);
    EXPECT_LT(thrown.overlap, 0) << "they fly apart";

    settings.stabilisation = Stabilisation::SplitImpulse;
    const Parting split = part(depth, settings);
    EXPECT_LT(std::abs(split.speed), 1e-6);
    EXPECT_LT(split.overlap, 0.01 * depth) << "and yet it has parted them";

    settings.stabilisation = Stabilisation::Soft;
    const Parting soft = part(depth, settings);
    EXPECT_LT(std::abs(soft.speed), 0.1 * depth / h);
    EXPECT_LT(soft.overlap, 0.01 * depth);
  }
}

TEST(SolverTraps, ThePushSpeedBoundsWhatBaumgarteAndSoftContactsThrow) {
  for (const double push : {0.5, 2.0}) {
    for (const Stabilisation stabilisation : {Stabilisation::Soft, Stabilisation::Baumgarte}) {
      const Parting parting = part(0.25, {.stabilisation = stabilisation, .contact_push_speed = push});
      EXPECT_LT(parting.speed, 1.01 * push) << static_cast<int>(stabilisation);
    }
    EXPECT_GT(part(0.25, {.stabilisation = Stabilisation::Baumgarte, .contact_push_speed = push}).speed, 0.9 * push);
  }
}

}  // namespace
}  // namespace atl::test
