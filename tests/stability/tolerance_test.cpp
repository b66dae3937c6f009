// A tolerance ends an island's sweeps with the first that changes no relative speed at a contact by more.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

/// Sweeps a substep where none is spared: Soft relaxes, SplitImpulse sweeps once more for its corrections.
int all_sweeps(const Settings& settings) {
  switch (settings.stabilisation) {
    case Stabilisation::Soft:
      return settings.iterations + settings.relax_iterations;
    case Stabilisation::SplitImpulse:
      return 2 * settings.iterations;
    case Stabilisation::Baumgarte:
      break;
  }
  return settings.iterations;
}

struct Outcome {
  std::int64_t sweeps = 0;
  std::vector<double> places;  ///< m, of all bodies after each step
};

Outcome run_stack(double tolerance, Stabilisation stabilisation) {
  SceneRun stack("stack:height=4", {.settings = {.iterations = 64,
                                                 .relax_iterations = 64,
                                                 .tolerance = tolerance,
                                                 .warm_starting = false,
                                                 .stabilisation = stabilisation}});
  Outcome outcome;
  for (int i = 0; i < 10; ++i) {
    outcome.sweeps += stack.world.step(dt).counts.sweeps;
    for (const double x : stack.world.positions().reshaped()) outcome.places.push_back(x);
  }
  return outcome;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(Tolerance, ALargerOneMeansFewerSweepsAndMoreError) {
  for (const Stabilisation stabilisation : all_stabilisations) {
    const Outcome all = run_stack(0, stabilisation);
    EXPECT_EQ(all.sweeps, 10 * 4 * (stabilisation == Stabilisation::Baumgarte ? 64 : 128)) << "none spared";
    std::int64_t sweeps = all.sweeps;
    double error = 0;
    for (const double tolerance : {1e-3, 1e-2, 1e-1}) {
      const Outcome now = run_stack(tolerance, stabilisation);
      const double difference = largest_difference(now.places, all.places);
      EXPECT_LT(now.sweeps, sweeps) << tolerance << ", " << static_cast<int>(stabilisation);
      EXPECT_GT(difference, error) << tolerance << ", " << static_cast<int>(stabilisation);
      // The velocity that a sweep leaves unsolved is below the tolerance, which bounds how far it moves a body.
      EXPECT_LT(difference, 10 * dt * 10 * tolerance) << tolerance << ", " << static_cast<int>(stabilisation);
      sweeps = now.sweeps;
      error = difference;
    }
  }
}

TEST(Tolerance, WhereNothingIsLeftToSolveOneSweepOfAKindIsEnough) {
  // Side by side in free space at rest: no contact has anything to do.
  World world({.gravity = Vector3::Zero(), .settings = {.iterations = 20, .relax_iterations = 20, .tolerance = 1e-9}});
  world.add_body(box({0, 0, 0}));
  world.add_body(box({1, 0, 0}));
  const StepReport report = run(world, 3);
  ASSERT_EQ(report.counts.contacts, 1);
  EXPECT_EQ(report.counts.sweeps, 4 * (1 + 1));
}

TEST(Tolerance, ZeroNeverEndsEarly) {
  for (const Stabilisation stabilisation : all_stabilisations) {
    const Settings settings = {.iterations = 5, .relax_iterations = 3, .stabilisation = stabilisation};
    World world({.gravity = Vector3::Zero(), .settings = settings});
    world.add_body(box({0, 0, 0}));
    world.add_body(box({1, 0, 0}));
    EXPECT_EQ(run(world, 3).counts.sweeps, 4 * all_sweeps(settings));
  }
}

TEST(Tolerance, OneTooSmallToMeetChangesNoBit) {
  const auto hash_of_positions = [](double tolerance) {
    SceneRun stack("stack:height=4", {.settings = {.iterations = 3, .tolerance = tolerance, .warm_starting = false}});
    std::vector<double> places;
    for (int i = 0; i < 20; ++i) {
      stack.world.step(dt);
      for (const double x : stack.world.positions().reshaped()) places.push_back(x);
    }
    return places;
  };
  EXPECT_EQ(hash_of_positions(0), hash_of_positions(1e-30));
}

/// Positions of a hit stack's bodies after each step, with or without other islands far away.
std::vector<double> hit_stack(int others, const WorldDef& def, std::int64_t* sweeps = nullptr) {
  World world(def);
  world.add_body(ground());
  std::vector<BodyId> ids = add_stack(world, 5);
  BodyDef ball = sphere({-1.5, 0.1, 3.3}, 0.3);
  ball.velocity = {8, 0, 0};
  ids.push_back(world.add_body(ball));
  for (int i = 0; i < others; ++i) {
    // Some have nothing left to solve soon, others keep on.
    const Vector3 base(50 + 5 * i, 0, 0);
    add_stack(world, 1 + i % 12, base);
    if (i % 3 == 0) world.add_body(sphere(base + Vector3(0.1, 0.2, 14), 0.4));
  }
  std::vector<double> trail;
  for (int i = 0; i < 90; ++i) {
    const StepReport report = world.step(dt);
    if (sweeps != nullptr) *sweeps += report.counts.sweeps;
    for (const BodyId id : ids) {
      for (const double x : world.pose(id).position) trail.push_back(x);
      for (const double x : world.velocity(id)) trail.push_back(x);
      for (const double x : world.angular_velocity(id)) trail.push_back(x);
    }
  }
  return trail;
}

TEST(Tolerance, NoIslandFeelsWhenAnotherIsDone) {
  for (const Stabilisation stabilisation : all_stabilisations) {
    for (const double tolerance : {1e-3, 3e-2}) {
      const Settings settings = {.iterations = 16, .tolerance = tolerance, .stabilisation = stabilisation};
      std::int64_t sweeps = 0;
      const std::vector<double> alone = hit_stack(0, {.settings = settings}, &sweeps);
      EXPECT_LT(sweeps, 90 * 4 * all_sweeps(settings)) << "sweeps were spared, so there is something to test";
      for (const int others : {1, 7, 40}) {
        EXPECT_EQ(hit_stack(others, {.settings = settings}), alone)
            << others << " others, " << tolerance << ", " << static_cast<int>(stabilisation);
      }
      EXPECT_EQ(hit_stack(40, {.threads = 4, .settings = settings}), alone) << "4 threads";
    }
  }
}

TEST(Tolerance, NorDoesTheInstructionSet) {
  Settings settings = {.iterations = 16, .tolerance = 1e-2};
  settings.simd = Simd::Portable;
  const std::vector<double> portable = hit_stack(7, {.settings = settings});
  settings.simd = Simd::Auto;
  EXPECT_EQ(hit_stack(7, {.settings = settings}), portable);
}

}  // namespace
}  // namespace atl::test
