#pragma once
/// The three ways in which a driver runs a scene. Each throws what the engine throws, and NonFinite.

#include "peer.h"

namespace peer {

/// The measurements that atl::ErrorMeter took by the end of a run.
struct Outcome {
  std::vector<atl::ErrorMeasure> errors;
  bool fell = false;
};

/// Once, every step timed.
struct SteppedRun {
  std::vector<double> ms;  ///< wall time by step
  std::vector<atl::BodyState> states;
  Outcome outcome;  ///< of the last states only
};
SteppedRun run_stepped(const Engine& engine, const atl::Scene& scene, const Setting& setting);

/// Once, observed after every step.
Outcome run_observed(const Engine& engine, const atl::Scene& scene, const Setting& setting);

/// Whole runs, each in a fresh simulation, until stepping took `seconds` of CPU time altogether.
struct TimedRuns {
  int runs = 0;
  double wall = 0;  ///< s, of stepping, of all runs
  double cpu = 0;   ///< s, of the process meanwhile
};
TimedRuns run_timed(const Engine& engine, const atl::Scene& scene, const Setting& setting, double seconds);

}  // namespace peer
