// Each pass nudges every constraint closer: more iterations leave no error larger, whatever gets bodies apart.

#include <atoll/error_meter.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "support/long_tests.h"
#include "support/scene_run.h"

namespace atl::test {
namespace {

using Errors = std::map<std::string, double>;

/// After a run of the scene: what bodies and joints are off by, and what the last sweeps of contacts left.
Errors errors_of(const std::string& text, Settings settings, int steps) {
  settings.keep_contact_problem = true;
  SceneRun run(text, {.settings = settings});
  ErrorMeter meter(run.scene);
  std::vector<BodyState> states(run.ids.size());
  for (int i = 1; i <= steps; ++i) {
    run.world.step(run.scene.dt);
    for (std::size_t k = 0; k < states.size(); ++k) {
      states[k] = {run.world.pose(run.ids[k]), run.world.velocity(run.ids[k]), run.world.angular_velocity(run.ids[k])};
    }
    meter.observe(i * run.scene.dt, states);
  }
  Errors errors = {{"contact_residual", measure_contact_residual(run.world.contact_problem()).relative}};
  for (const ErrorMeasure& measure : meter.errors()) {
    for (const char* name : {"drift_max", "penetration_max", "joint_gap_run_mean"}) {
      if (measure.name == name) errors[name] = measure.value;
    }
  }
  // Rigid contacts leave the slop alone.
  if (settings.stabilisation != Stabilisation::Soft && errors.contains("penetration_max")) {
    errors["penetration_max"] = std::max(errors["penetration_max"], settings.slop);
  }
  return errors;
}

// Expects no error to grow by more than a twentieth, or by what rounding leaves, from count to count.
template <typename Set>
void expect_no_growth(const std::string& scene, int steps, Settings settings, const std::vector<int>& counts,
                      const Set& set) {
  Errors before;
  for (const int count : counts) {
    set(settings, count);
    const Errors now = errors_of(scene, settings, steps);
    for (const auto& [name, value] : now) {
      const double slack = name == "contact_residual" ? 2e-3 : 1e-5;
      if (!before.empty()) {
        EXPECT_LE(value, 1.05 * before[name] + slack) << name << " of " << scene << " at " << count
                                                      << ", stabilisation " << static_cast<int>(settings.stabilisation);
      }
    }
    before = now;
  }
}

std::vector<int> doublings(int max, int min = 1) {
  std::vector<int> counts;
  for (int count = min; count <= max; count *= 2) counts.push_back(count);
  return counts;
}

const auto set_iterations = [](Settings& settings, int count) { settings.iterations = count; };

struct Case {
  const char* scene;
  int steps;
};

TEST(Knob, MoreIterationsMakeNoErrorLarger) {
  std::vector<Case> cases = {{"wall:base=16", 100}, {"pyramid3d:layers=6", 100}, {"stack", 200}};
  if (long_tests()) {
    cases = {{"wall:base=20", 200},
             {"pyramid3d:layers=8", 200},
             {"islands:count=4", 200},
             {"stack", 200},
             {"sliding-blocks:headings=24", 200},
             {"incline", 200},
             {"tipping-block", 200},
             {"rolling-sphere", 200},
             {"rolling-resistance", 200},
             {"torsion", 200},
             {"incline-sphere", 200},
             {"pushed-box", 200}};
  }
  for (const Case& of : cases) {
    for (const Stabilisation stabilisation : all_stabilisations) {
      // With fewer a tower on rigid contacts falls, and one that lies has little left to solve.
      const int min = stabilisation == Stabilisation::Soft ? 1 : 4;
      expect_no_growth(of.scene, of.steps, {.stabilisation = stabilisation, .contact_solver = ContactSolver::Iterative},
                       doublings(long_tests() ? 64 : 16, min), set_iterations);
    }
  }
}

// A heap falls otherwise with every change: only means over many poses tell.
TEST(Knob, HeapsOverlapNoMoreByMoreIterations) {
  std::vector<Case> cases = {{"pile:bodies=60", 200}};
  if (long_tests()) {
    cases = {{"pile:bodies=150", 300},
             {"marbles:bodies=150", 300},
             {"rocks:bodies=100", 300},
             {"mixed:bodies=100", 300},
             {"drum:boxes=100", 200},
             {"terrain:bodies=10,triangles=2000", 200},
             {"hopper:bodies=100", 300},
             {"conveyor", 300},
             {"ragdolls:count=4", 200},
             {"bridge:planks=20", 200},
             {"vehicle", 200}};
  }
  const std::uint64_t seeds = long_tests() ? 12 : 3;
  for (const Case& of : cases) {
    for (const Stabilisation stabilisation : all_stabilisations) {
      const auto overlap = [&](int iterations) {
        double sum = 0;
        int looks = 0;
        for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
          const Settings settings = {.iterations = iterations, .stabilisation = stabilisation};
          SceneRun run(load_scene(of.scene, seed), {.settings = settings});
          for (int i = 1; i <= of.steps; ++i) {
            run.world.step(run.scene.dt);
            if (2 * i < of.steps || i % 10 != 0) continue;
            sum += run.penetration().mean;
            ++looks;
          }
        }
        return sum / looks;
      };
      const double slack = stabilisation == Stabilisation::Soft ? 5e-5 : Settings{}.slop;
      const double first = overlap(1);
      for (const int iterations : {8, 64}) {
        EXPECT_LE(overlap(iterations), 1.25 * first + slack)
            << of.scene << " at " << iterations << ", stabilisation " << static_cast<int>(stabilisation);
      }
    }
  }
}

TEST(Knob, MoreIterationsOpenNoSweptJointFarther) {
  for (const char* scene : {"chain:links=20,ratio=100", "joint-grid:n=12"}) {
    for (const Stabilisation stabilisation : all_stabilisations) {
      expect_no_growth(scene, 100, {.stabilisation = stabilisation, .joint_solver = JointSolver::Iterative},
                       doublings(long_tests() ? 64 : 16), set_iterations);
    }
  }
}

// Rigid joints are open by what sweeps leave alone.
TEST(Knob, RigidSweptJointsCloseAsIterationsGrow) {
  const std::vector<Case> cases = {{"chain:links=20,ratio=100", 200}, {"joint-grid:n=12", 100}, {"bridge", 100}};
  for (const Case& of : cases) {
    for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
      const auto gap = [&](int iterations) {
        const Settings settings = {
            .iterations = iterations, .stabilisation = stabilisation, .joint_solver = JointSolver::Iterative};
        return errors_of(of.scene, settings, of.steps).at("joint_gap_run_mean");
      };
      EXPECT_LE(gap(32), 0.1 * gap(4)) << of.scene << ", stabilisation " << static_cast<int>(stabilisation);
    }
  }
}

// Errors that are asked back as speed ring up in a net that sweeps are slow to solve, unless fewer impulses are carried
// over.
TEST(Knob, ANetOfRigidSweptJointsHoldsFromOneSweepOn) {
  for (const Stabilisation stabilisation : {Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    const Settings settings = {.stabilisation = stabilisation, .joint_solver = JointSolver::Iterative};
    EXPECT_LE(errors_of("joint-grid:n=12", settings, 100).at("joint_gap_run_mean"), 3e-3)
        << static_cast<int>(stabilisation);
  }
}

TEST(Knob, ASmallerToleranceAndMoreSubstepsMakeNoErrorLarger) {
  for (const char* scene : {"wall:base=16", "pyramid3d:layers=6"}) {
    expect_no_growth(scene, 100, {.iterations = 32}, {1, 10, 100, 1000, 10000},
                     [](Settings& settings, int parts) { settings.tolerance = 1.0 / parts; });
    expect_no_growth(scene, 100, {}, doublings(16),
                     [](Settings& settings, int substeps) { settings.substeps = substeps; });
  }
}

}  // namespace
}  // namespace atl::test
