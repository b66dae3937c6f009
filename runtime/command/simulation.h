#pragma once

#include <atoll/scene.h>
#include <atoll/world.h>

#include <array>
#include <cstdint>
#include <vector>

#include "state_csv.h"

namespace atl::view {
class Watcher;
}

namespace atl::command {

/// Over the steps of a run, ms.
struct StepTimes {
  double mean = 0;
  double median = 0;
  double p99 = 0;  ///< nearest rank
  double max = 0;
  int longest = 0;  ///< the step that took that; the first is 1
};

/// A body that a run lost: see World::quarantined().
struct LostBody {
  std::int64_t step;  ///< the first is 1
  std::size_t body;   ///< place in the scene's list
  const char* why;
};

/// An island that sweeps could not hold up: see World::solver_choices().
struct SolveOfBody {
  std::size_t body;  ///< the lowest of it: place in the scene's list
  SolverChoice island;
};

/// With a target: what islands got for it over the steps of a run, and whether that held their errors.
struct TargetTally {
  std::int64_t bodies = 0;         ///< of islands, of all steps
  std::int64_t body_substeps = 0;  ///< that these got
  std::int64_t max_substeps = 0;   ///< that an island got in a step
  std::int64_t missed_steps = 0;   ///< with an island beyond its target
  std::int64_t missed_targets = 0;

  void add(const StepCounts& counts);
  double mean_substeps() const;  ///< that a body got in a step
};

/// An error beyond its target: see World::missed_targets().
struct MissedOfBody {
  std::size_t body;  ///< the lowest of the island: place in the scene's list
  MissedTarget island;
};

/// The result of a scene's run.
struct RunResult {
  int steps = 0;             ///< that were done: all of the scene's, unless broken or interrupted
  bool interrupted = false;  ///< by a signal, after at least one step
  StepTimes step_times;
  std::array<double, phase_count> phase_ms = {};  ///< mean
  /// Means, with Settings::profile only.
  std::array<double, solver_phase_count> solver_ms = {};
  double points = 0;                        ///< mean, of manifolds
  StepReport last;                          ///< of the last step
  std::vector<SolveOfBody> solver_choices;  ///< likewise
  TargetTally target;
  std::vector<MissedOfBody> missed_targets;  ///< of the last step
  std::vector<LostBody> lost;                ///< in order of ids
  bool broken = false;                       ///< ended by a body that was lost: the measures below are not set
  std::vector<ErrorMeasure> errors;
  std::uint64_t hash = 0;
  BodyStates final_state;  ///< where it was asked for; of a broken run, before the step that broke it
};

/// Options of simulate(): the results to keep and measure on the way.
struct Keep {
  bool final_state = false;
  bool errors = false;  ///< of every step; else of the final state only
  bool going = false;   ///< whatever bodies are lost
  std::vector<view::Watcher*> watchers = {};
};

/// A world for the scene, with nothing in it. Throws Failure on what this machine lacks.
World make_world(const Scene& scene, int threads);

/// Runs a scene that was built into the world as `ids`, and measures its errors. A signal ends it after the step that
/// is under way, or the first: what there is by then is measured all the same.
RunResult simulate(const Scene& scene, World& world, const std::vector<BodyId>& ids, const Keep& keep);

}  // namespace atl::command
