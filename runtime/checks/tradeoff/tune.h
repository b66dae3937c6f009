#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "grid.h"
#include "record.h"
#include "scene_sweep.h"

namespace atl::tradeoff {

/// How far bodies overlap and joints open once a scene has come to rest: the largest, over the last quarter of the
/// steps, of what one in a hundred pairs of bodies, or of joints, exceeds after a step.
struct RestErrors {
  double penetration = 0;   ///< m
  double joint_gap = 0;     ///< m, of locked offsets
  double steps_within = 0;  ///< share of all steps after which both were within the error that is asked for

  double worst() const { return penetration > joint_gap ? penetration : joint_gap; }
};

/// Fixed settings that were tried.
struct Trial {
  Configuration configuration;
  Record record;  ///< outcome and hash; times, if it was timed
  RestErrors errors;
  bool selects = false;  ///< contacts of some island, in some step, were not left to sweeps
  bool holds = false;    ///< it came to its end, with errors at rest within what is asked for
};

/// m: of overlaps that are smaller measure_penetration() tells nothing.
inline constexpr double min_tuned_error = 1e-5;

/// The substeps that are tried: a quarter of an octave apart.
std::vector<int> tuning_ladder();

struct Tuning {
  std::vector<Trial> trials;                  ///< in the order in which they were run
  std::vector<std::size_t> timed;             ///< of these: the fewest substeps that hold, of each pair of solvers
  std::optional<std::size_t> cheapest;        ///< of the timed, by median CPU time
  std::optional<std::size_t> smallest_error;  ///< of those that came to their end
};

/// The scene with its own settings alone, but without a target: what is looked for are fixed settings.
ScenePlan plan_to_tune(const std::string& address, std::uint64_t seed, std::optional<int> steps);

/// Finds the cheapest fixed settings that hold penetrations and gaps of joints within `error`, m, at least the least:
/// of each pair of solvers of contacts and of joints that makes a difference the fewest substeps that do, and of these
/// the cheapest. Errors fall with the square of the substeps, so a trial tells where about to look; a rung counts only
/// if the one above it holds too, as errors of bodies that bump into each other have luck in them. Errors, and so what
/// is timed, are the same on every machine. Throws Stopped, and SceneError on settings that this machine lacks.
Tuning tune(const ScenePlan& plan, double error, const RunPolicy& policy,
            const std::function<void(const Trial&)>& tried);

}  // namespace atl::tradeoff
