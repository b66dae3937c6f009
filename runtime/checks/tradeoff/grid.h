#pragma once

#include <atoll/scene.h>
#include <atoll/world.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "axes.h"

namespace atl::tradeoff {

/// Which settings a scene is run with, and how long.
struct GridOptions {
  std::map<std::string, std::vector<std::string>> lists;  ///< values by axis; the grid's own where there is none
  bool quick = false;                                     ///< a coarse grid, fewer steps of large scenes
  std::optional<int> steps;                               ///< at the scene's own dt
  std::uint64_t seed = 1;                                 ///< of a scene's random content
};

/// A scene and the settings to run it with.
struct ScenePlan {
  std::string address = {};  ///< what load_scene read it from; "" of a scene that is none of its
  Scene scene = {};          ///< steps as they are run, at the scene's own dt
  int scene_steps = 0;       ///< the scene's own number
  bool large = false;
  std::vector<Configuration> configurations =
      {};  ///< the scene's own first; one thread, but where that is what is varied

  /// Neither a closed form nor an ideal rest pose: no two engines end in the same state.
  bool chaotic() const { return !scene.closed_form && !scene.starts_at_rest; }
  double simulated_time() const { return scene.steps * scene.dt; }  ///< s
  int steps(const Configuration& configuration) const;              ///< for that time
};

/// A scene of more dynamic bodies than this is large. It gets a thinner grid, and no more steps than give 0.3 million
/// body steps (--quick: 0.1 million), but at least 10; where bodies fall, at least as many as it takes until they have
/// landed.
inline constexpr std::size_t max_bodies_of_small = 1000;

/// Bodies that fall have landed once this share of the dynamic ones touches something. Before that there is next to no
/// overlap to judge.
inline constexpr double landed_share = 0.5;
std::size_t dynamic_bodies(const Scene& scene);
/// The share of a scene's dynamic bodies on which something pressed in the last step; `ids` as of build_scene.
double touching_share(const Scene& scene, const World& world, const std::vector<BodyId>& ids);

/// Substeps times iterations, in small scenes with joints substeps times solvers of these, and from the scene's own
/// settings each other axis for itself: the tolerance with the most iterations. No configuration twice, and by default
/// none that can make no difference in this scene. Throws SceneError, and Error on a value that its axis doesn't take.
ScenePlan plan_scene(const std::string& address, const GridOptions& options);
ScenePlan plan_scene(Scene scene, const GridOptions& options);

}  // namespace atl::tradeoff
