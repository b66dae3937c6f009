#include "figures.h"

#include <array>

namespace atl::command {

std::vector<Count> named_counts(const StepCounts& c) {
  return {{"pairs", c.pairs},
          {"contacts", c.contacts},
          {"points", c.points},
          {"joints", c.joints},
          {"islands", c.islands},
          {"groups", c.groups},
          {"colours", c.colours},
          {"fcl_calls", c.fcl_calls},
          {"fcl_repairs", c.fcl_repairs},
          {"recycled_manifolds", c.recycled_manifolds},
          {"recomputed_manifolds", c.recomputed_manifolds},
          {"asleep", c.asleep},
          {"id_matches", c.id_matches},
          {"id_misses", c.id_misses},
          {"swept", c.swept},
          {"stopped", c.stopped},
          {"sweeps", c.sweeps},
          {"direct_joints", c.direct_joints},
          {"direct_islands", c.direct_islands},
          {"refined_islands", c.refined_islands},
          {"unsolved_islands", c.unsolved_islands},
          {"refused_islands", c.refused_islands},
          {"missed_targets", c.missed_targets},
          {"body_substeps", c.body_substeps},
          {"island_bodies", c.island_bodies},
          {"max_substeps", c.max_substeps},
          {"newton_iterations", c.newton_iterations},
          {"discarded_iterations", c.discarded_iterations},
          {"aabb_updates", c.aabb_updates}};
}

const char* name_of(TargetError error) {
  constexpr std::array names = {"penetration", "joint_gap", "residual", "motion"};
  return names[static_cast<std::size_t>(error)];
}

const char* unit_of(TargetError error) {
  constexpr std::array units = {"m", "m", "", "m/s"};
  return units[static_cast<std::size_t>(error)];
}

double limit_of(const ErrorTarget& target, TargetError error) {
  const std::array limits = {target.penetration, target.joint_gap, target.residual, target.motion};
  return limits[static_cast<std::size_t>(error)].value_or(0);
}

BodyCounts body_counts(const Scene& scene) {
  BodyCounts counts;
  for (const SceneBody& body : scene.bodies) {
    switch (body.def.type) {
      case BodyType::Dynamic:
        ++counts.dynamic;
        break;
      case BodyType::Static:
        ++counts.fixed;
        break;
      case BodyType::Kinematic:
        ++counts.kinematic;
        break;
    }
  }
  return counts;
}

std::string body_words(const Scene& scene, std::size_t body) {
  const bool named = body < scene.bodies.size() && !scene.bodies[body].name.empty();
  return "body " + std::to_string(body) + (named ? " \"" + scene.bodies[body].name + "\"" : "");
}

std::string lost_words(const Scene& scene, const LostBody& lost) {
  return body_words(scene, lost.body) + " was quarantined in step " + std::to_string(lost.step) + " of " +
         std::to_string(scene.steps) + ": " + lost.why;
}

}  // namespace atl::command
