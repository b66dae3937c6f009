// Every choice of how contacts are solved changes the result in the direction that theory says.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/scene_run.h"

namespace atl::test {
namespace {

/// Deepest penetration of a stack that is left to sweeps, while and after it takes up its weight.
double worst_penetration(int height, Settings settings, int steps = 60) {
  settings.contact_solver = ContactSolver::Iterative;
  SceneRun stack("stack:height=" + std::to_string(height), {.settings = settings});
  double worst = 0;
  for (int i = 0; i < steps; ++i) {
    stack.world.step(dt);
    worst = std::max(worst, stack.penetration().max);
  }
  return worst;
}

TEST(Stabilisation, SubstepsLowerThePenetrationOfAStack) {
  for (const Stabilisation stabilisation : all_stabilisations) {
    double before = 1e9;
    for (const int substeps : {1, 2, 4, 8}) {
      const double now = worst_penetration(5, {.substeps = substeps, .stabilisation = stabilisation});
      EXPECT_LT(now, 0.7 * before) << static_cast<int>(stabilisation) << ", " << substeps << " substeps";
      before = now;
    }
  }
}

TEST(Stabilisation, IterationsLowerThePenetrationOfAStack) {
  for (const Stabilisation stabilisation : all_stabilisations) {
    double before = 1e9;
    for (const int iterations : {1, 4, 16}) {
      const double now =
          worst_penetration(5, {.iterations = iterations, .warm_starting = false, .stabilisation = stabilisation});
      EXPECT_LT(now, 0.8 * before) << static_cast<int>(stabilisation) << ", " << iterations << " iterations";
      before = now;
    }
  }
}

TEST(Stabilisation, RelaxIterationsLowerThePenetrationOfAStack) {
  double before = 1e9;
  for (const int relax : {0, 1, 4}) {
    const double now = worst_penetration(5, {.relax_iterations = relax, .warm_starting = false});
    EXPECT_LT(now, before) << relax << " relax iterations";
    before = now;
  }
}

TEST(Stabilisation, WarmStartingLowersThePenetrationOfAStackAtEqualSweeps) {
  for (const Stabilisation stabilisation : all_stabilisations) {
    const double warm = worst_penetration(10, {.warm_starting = true, .stabilisation = stabilisation});
    const double cold = worst_penetration(10, {.warm_starting = false, .stabilisation = stabilisation});
    EXPECT_LT(warm, 0.5 * cold) << static_cast<int>(stabilisation);
  }
}

// Rigid contacts leave no overlap under a weight at rest, where soft ones give way.
TEST(Stabilisation, RigidContactsDoNotGiveWayUnderAWeightAtRest) {
  const auto at_rest = [](Stabilisation stabilisation) {
    SceneRun stack("stack:height=2", {.settings = {.iterations = 8, .stabilisation = stabilisation, .slop = 0}});
    run_finite(stack.world, 300);
    EXPECT_LT(kinetic_energy(stack.world, dynamic_bodies(stack.world, stack.ids)), 1e-6);
    return stack.penetration().max;
  };
  const double soft = at_rest(Stabilisation::Soft);
  EXPECT_LT(at_rest(Stabilisation::Baumgarte), 0.2 * soft);
  EXPECT_LT(at_rest(Stabilisation::SplitImpulse), 0.2 * soft);
}

TEST(Stabilisation, AStackOfRigidContactsComesToRest) {
  for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    SceneRun stack("stack:height=10", {.settings = {.iterations = 10, .stabilisation = stabilisation}});
    run_finite(stack.world, 300);
    // 10 t at less than 5 mm/s; g h is 41.
    EXPECT_LT(kinetic_energy(stack.world, dynamic_bodies(stack.world, stack.ids)), 0.1);
    const RestReport rest = stack.rest();
    EXPECT_LT(rest.sink_max, 0.01) << static_cast<int>(stabilisation);
    EXPECT_LT(rest.drift_max, 0.01) << static_cast<int>(stabilisation);
    EXPECT_LT(rest.tilt_max, 1e-3) << static_cast<int>(stabilisation);
  }
}

// In free space with nothing else to solve, a substep removes its share of the overlap beyond the slop and leaves the
// rest; the sweeps are for the four points of the one contact.
TEST(Stabilisation, CorrectionRemovesItsShareOfTheOverlapASubstep) {
  constexpr double depth = 0.1;
  struct Choice {
    double correction, slop;
  };
  for (const auto& [correction, slop] : {Choice{0.1, 0}, Choice{0.2, 0}, Choice{0.5, 0}, Choice{0.2, 0.02}}) {
    for (const int substeps : {1, 4}) {
      World world({.gravity = Vector3::Zero(),
                   .settings = {.substeps = substeps,
                                .iterations = 64,
                                .stabilisation = Stabilisation::SplitImpulse,
                                .correction = correction,
                                .slop = slop,
                                .contact_push_speed = 1e3}});
      const BodyId a = world.add_body(box({0, 0, 0})), b = world.add_body(box({1 - depth, 0, 0}));
      for (int step = 1; step <= 4; ++step) {
        world.step(dt);
        const double expected = slop + (depth - slop) * std::pow(1 - correction, step * substeps);
        EXPECT_NEAR(overlap(placed(world, a, Box{}), placed(world, b, Box{})), expected, 1e-3 * depth)
            << correction << ", slop " << slop << ", " << substeps << " substeps, step " << step;
      }
    }
  }
}

TEST(Stabilisation, FullCorrectionRemovesAllOverlapInOneSubstep) {
  World world({.gravity = Vector3::Zero(),
               .settings = {.substeps = 1,
                            .iterations = 64,
                            .stabilisation = Stabilisation::SplitImpulse,
                            .correction = 1,
                            .slop = 0,
                            .contact_push_speed = 1e3}});
  const BodyId a = world.add_body(box({0, 0, 0})), b = world.add_body(box({0.9, 0, 0}));
  world.step(dt);
  EXPECT_NEAR(overlap(placed(world, a, Box{}), placed(world, b, Box{})), 0, 1e-5);
  EXPECT_LT(world.velocity(b).norm(), 1e-6);
}

// A box of 1 m on the ground, sunk in: a split impulse lifts it without a jump.
TEST(Stabilisation, SplitImpulsesLiftASunkenBoxWithoutAJump) {
  const auto highest = [](Stabilisation stabilisation) {
    World world({.settings = {.stabilisation = stabilisation, .contact_push_speed = 1e3}});
    world.add_body(ground());
    const BodyId crate = world.add_body(box({0, 0, 0.4}));
    double height = 0;
    for (int i = 0; i < 120; ++i) {
      world.step(dt);
      height = std::max(height, world.pose(crate).position.z());
    }
    return height;
  };
  // 0.2 * 0.1 m in a substep is 4.8 m/s, which carry it v^2 / 2g upwards.
  EXPECT_GT(highest(Stabilisation::Baumgarte), 1.3);
  EXPECT_LT(highest(Stabilisation::SplitImpulse), 0.501);
}

TEST(Stabilisation, OverlapWithinTheSlopIsLeftAlone) {
  for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    const auto left = [=](double slop) {
      World world({.gravity = Vector3::Zero(), .settings = {.stabilisation = stabilisation, .slop = slop}});
      const BodyId a = world.add_body(box({0, 0, 0})), b = world.add_body(box({0.99, 0, 0}));
      run(world, 60);
      return overlap(placed(world, a, Box{}), placed(world, b, Box{}));
    };
    EXPECT_NEAR(left(0.02), 0.01, 1e-6) << static_cast<int>(stabilisation);
    EXPECT_LT(left(0.005), 0.006) << static_cast<int>(stabilisation);
  }
}

/// Deceleration along its heading of a block that slides, over mu g.
double braking(double heading, FrictionModel model) {
  constexpr double friction = 0.5, speed = 5;
  constexpr int settle = 6, steps = 6;  // the contact takes up the load first
  World world({.settings = {.friction = model}});
  world.add_body(ground(friction));
  const Vector3 forward(std::cos(heading), std::sin(heading), 0);
  BodyDef def = box({0, 0, 0.25}, {0.5, 0.5, 0.25});
  def.velocity = speed * forward;
  def.material.friction = friction;
  const BodyId block = world.add_body(def);
  run(world, settle);
  const Vector3 before = world.velocity(block);
  run(world, steps);
  return (before - world.velocity(block)).dot(forward) / (friction * g * steps * dt);
}

TEST(Stabilisation, PyramidsFrictionIsTooStrongBySqrt2OffItsAxesAndTheConesIsNot) {
  double min = 1e9, max = 0;
  for (int i = 0; i < 24; ++i) {
    const double heading = i * std::numbers::pi / 12;
    EXPECT_NEAR(braking(heading, FrictionModel::Cone), 1, 0.01) << 15 * i;
    const double pyramid = braking(heading, FrictionModel::Pyramid);
    min = std::min(min, pyramid);
    max = std::max(max, pyramid);
  }
  EXPECT_NEAR(min, 1, 0.01) << "on an axis";
  EXPECT_NEAR(max, std::sqrt(2), 0.02) << "on a diagonal";
}

}  // namespace
}  // namespace atl::test
