#pragma once

#include <atoll/scene.h>

#include <vector>

#include "axes.h"
#include "sweep_options.h"

namespace atl::command {

/// A scene and the settings to run it with.
struct ScenePlan {
  std::string address = {};  ///< what load_scene read it from
  Scene scene = {};          ///< steps as they are run, at the scene's own dt
  int scene_steps = 0;       ///< the scene's own number
  bool large = false;
  std::vector<Configuration> configurations =
      {};  ///< the scene's own first; one thread, but where that is what is varied

  double simulated_time() const { return scene.steps * scene.dt; }  ///< s
  int steps(const Configuration& configuration) const;              ///< for that time
};

/// A scene of more dynamic bodies than this is large. It gets a thinner grid, and no more steps than give 0.3 million
/// body steps (--quick: 0.1 million), but at least 10.
inline constexpr std::size_t most_bodies_of_small = 1000;

/// Substeps times iterations, in small scenes with joints substeps times solvers of these, and from the scene's own
/// settings each other axis for itself: the tolerance with the most iterations. No configuration twice, and by default
/// none that can make no difference in this scene. Throws SceneError.
ScenePlan plan_scene(const std::string& address, const SweepOptions& options);

}  // namespace atl::command
