#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "peer_driver.h"

namespace atl::tradeoff {

/// A scene that grows stiffer rung by rung, and what it takes to stand on one.
struct Ladder {
  struct Limit {
    std::string measure;  ///< an error of the final state; where a run has no such measure the limit holds
    double max;
  };
  std::string name;  ///< what grows, as "boxes of a tower"
  std::string scene;
  std::string survives;  ///< the limits in words
  std::vector<double> rungs = {};
  std::function<PeerRun(double rung)> run = {};
  std::vector<Limit> limits = {};
};

/// How far one engine gets, at so many substeps.
struct Reach {
  std::string engine;
  int substeps = 1;
  bool is_default = false;     ///< of Atoll
  std::optional<double> rung;  ///< the last of those up to which every one is survived; none if the first isn't
  double ms_per_step = 0;      ///< there, wall time on one thread
};

struct Frontier {
  Ladder ladder;
  std::vector<Reach> reaches;  ///< Atoll first
};

/// Height and mass ratio of towers, mass ratio and length of chains, length of the step.
std::vector<Ladder> stiff_ladders();

/// Climbs a ladder with 1, 2, 4, 8 and 16 substeps, or if `quick` with 4, and all else at the defaults. Errors of
/// Atoll, and so how far it gets, are the same on every machine. Throws as sweep_scene() does, and Stopped.
Frontier climb(const Ladder& ladder, const std::vector<PeerDriver>& drivers, bool quick, const Stop& stop = {});

}  // namespace atl::tradeoff
