#pragma once

#include "checks/stability/suite.h"

namespace atl::stability {

/// A scene's run on one thread, up to the first step that leaves a bad state.
struct Simulated {
  History history;
  std::vector<double> ms = {};  ///< by step
  std::optional<BadState> bad_state = {};
};

/// Keeps a reference to the scene.
Simulated simulate(const Scene& scene, int steps);

}  // namespace atl::stability
