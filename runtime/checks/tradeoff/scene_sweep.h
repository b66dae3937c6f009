#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "peer_driver.h"
#include "scene_report.h"
#include "stop.h"

namespace atl::tradeoff {

/// How often and how long things are run.
struct RunPolicy {
  int repeats = 3;          ///< timing rounds; in each, every setting of every engine is timed once
  double min_time = 0.03;   ///< s of stepping in one of them
  double peer_budget = 30;  ///< s of another engine's runs for errors after which its other settings are not tried
  Stop stop = {};
  /// s of wall time after which a setting is not timed again.
  static constexpr double enough = 1;

  /// The default policy; a cheaper one if `quick`.
  static RunPolicy standard(bool quick);
};
/// s that a run of another engine may usually take.
inline constexpr double peer_limit = 25, quick_peer_limit = 6;

/// Work in a scene, for a bar: bodies times sweeps over their contacts, and as much for a guess for other engines.
std::int64_t estimate_work(const ScenePlan& plan, const std::vector<PeerDriver>& drivers, const RunPolicy& policy);

/// Tells of finished work.
using WorkDone = std::function<void(std::int64_t)>;

/// Runs all settings of all engines: first the errors, one setting after another, then the times, round robin. Once it
/// was stopped, those are left out that were not timed by then: all, where the scene's own settings were not. Throws
/// OtherBits, DriverError, and SceneError on settings that this machine lacks.
SceneReport sweep_scene(ScenePlan plan, const std::vector<PeerDriver>& drivers, const RunPolicy& policy,
                        std::uint64_t seed, const WorkDone& work_done);

}  // namespace atl::tradeoff
