#include "scene_traits.h"

#include <atoll/world.h>

#include <algorithm>

#include "checks/tradeoff/axes.h"
#include "checks/tradeoff/setting_names.h"

namespace atl::tradeoff {
namespace {

// How many joints a solver of joints takes at once in a scene.
std::int64_t direct_joints(const Scene& scene, const std::string& solver) {
  Settings settings = scene.settings;
  settings.joint_solver = joint_solver_named(solver);
  World world({.gravity = scene.gravity, .settings = settings});
  build_scene(scene, world);
  return world.step(scene.dt).counts.direct_joints;
}

}  // namespace

bool nothing_touches(const Scene& scene) {
  const auto passes = [&](const SceneBody& body) {
    const int group = body.def.filter.group;
    return group < 0 && group == scene.bodies.front().def.filter.group;
  };
  return std::all_of(scene.bodies.begin(), scene.bodies.end(), passes);
}

std::vector<std::string> different_joint_solvers(const Scene& scene, std::vector<std::int64_t>* direct) {
  std::vector<std::string> solvers;
  if (scene.joints.empty()) return solvers;
  std::vector<std::int64_t> counts;
  const std::string own = name_of(scene.settings.joint_solver);
  for (const std::string& solver : {own, std::string("auto"), std::string("iterative"), std::string("direct")}) {
    const std::int64_t count = direct_joints(scene, solver);
    // One of two solvers solves all joints directly that the other does, so equal counts mean equal sets.
    if (std::find(counts.begin(), counts.end(), count) != counts.end()) continue;
    solvers.push_back(solver);
    counts.push_back(count);
  }
  if (direct != nullptr) *direct = std::move(counts);
  return solvers;
}

}  // namespace atl::tradeoff
