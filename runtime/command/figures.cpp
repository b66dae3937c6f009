#include "figures.h"

#include <cinttypes>
#include <cstdio>

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
          {"kept_manifolds", c.kept_manifolds},
          {"asleep", c.asleep},
          {"id_matches", c.id_matches},
          {"id_misses", c.id_misses},
          {"swept", c.swept},
          {"stopped", c.stopped},
          {"sweeps", c.sweeps},
          {"direct_joints", c.direct_joints},
          {"direct_islands", c.direct_islands},
          {"finer_islands", c.finer_islands},
          {"newton_iterations", c.newton_iterations}};
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

std::string lost_words(const Scene& scene, const LostBody& lost) {
  std::string body = "body " + std::to_string(lost.body);
  if (lost.body < scene.bodies.size() && !scene.bodies[lost.body].name.empty()) {
    body += " \"" + scene.bodies[lost.body].name + "\"";
  }
  return body + " was quarantined in step " + std::to_string(lost.step) + " of " + std::to_string(scene.steps) + ": " +
         lost.why;
}

std::string hash_text(std::uint64_t hash) {
  char text[19];
  std::snprintf(text, sizeof text, "0x%016" PRIx64, hash);
  return text;
}

}  // namespace atl::command
