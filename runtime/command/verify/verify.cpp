#include "verify.h"

#include "../failure.h"
#include "determinism_check.h"
#include "scene/src/words.h"
#include "stability_check.h"

namespace atl::command {

void verify(const VerifyOptions& options, const divergence::Meddle& meddle) {
  const bool has_scene = !options.scene.text.empty();
  if (has_scene && options.stability) {
    throw Failure(Status::Usage, "verify: found the scene " + scene::quote(options.scene.text) +
                                     " and --stability, expected one of them (see atoll verify --help)");
  }
  if (has_scene) {
    check_determinism(options, meddle);
  } else if (options.stability) {
    check_stability(options);
  } else {
    throw Failure(Status::Usage,
                  "verify: found no check to make, expected a scene or --stability (see atoll verify --help)");
  }
}

}  // namespace atl::command
