#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "checks/tradeoff/frontier.h"
#include "checks/tradeoff/scene_report.h"
#include "surroundings.h"

namespace atl::command {

struct EngineVersion {
  std::string name;
  std::string version;
  std::string precision;
};

/// The results of a sweep. Errors of Atoll in it are the same on every machine; everything that follows from times is
/// not.
struct SweepResults {
  Surroundings surroundings;
  std::vector<EngineVersion> engines;  ///< Atoll first
  bool quick = false;
  int repeats = 1;
  double time = 0;  ///< s
  std::uint64_t seed = 1;
  std::vector<tradeoff::SceneReport> scenes;
  std::vector<tradeoff::Frontier> frontiers = {};  ///< where they were asked for
  bool interrupted = false;                        ///< by a signal: not all that was asked for is here
};

/// All figures, fronts and verdicts.
void write_results_json(std::ostream& out, const SweepResults& results);

/// One row a run.
void write_results_csv(std::ostream& out, const SweepResults& results);

/// One HTML page that needs no other file. `date` is shown.
void write_results_page(std::ostream& out, const SweepResults& results, const std::string& date);

/// For people, on a terminal: a paragraph a scene.
void write_results_text(std::ostream& out, const SweepResults& results);

}  // namespace atl::command
