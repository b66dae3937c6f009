#include "verify.h"

#include "../failure.h"
#include "checks.h"
#include "scene/src/words.h"

namespace atl::command {

void verify(const VerifyOptions& options, const divergence::Meddle& meddle) {
  const bool has_scene = !options.scene.text.empty();
  const char* suite = options.stability ? "--stability" : "--physics";
  if (has_scene && (options.stability || options.physics)) {
    throw Failure(Status::Usage, "verify: found the scene " + scene::quote(options.scene.text) + " and " + suite +
                                     ", expected one of them (see atoll verify --help)");
  }
  if (options.stability && options.physics) {
    throw Failure(Status::Usage,
                  "verify: found --stability and --physics, expected one of them (see atoll verify --help)");
  }
  if (options.refine && !options.physics) {
    throw Failure(Status::Usage, "verify: found --refine without --physics (see atoll verify --help)");
  }
  if (has_scene) {
    check_determinism(options, meddle);
  } else if (options.stability) {
    check_stability(options);
  } else if (options.physics) {
    check_physics(options);
  } else {
    throw Failure(
        Status::Usage,
        "verify: found no check to make, expected a scene, --stability or --physics (see atoll verify --help)");
  }
}

}  // namespace atl::command
