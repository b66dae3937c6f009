#pragma once

#include <atoll/atoll.h>

#include "consistency.h"

namespace atl::fuzz {

/// Steps a world that came of a file, if its bodies are few enough for that to be quick.
inline void few_steps(World& world, int steps) {
  check_world(world);
  const Settings& settings = world.settings();
  const long sweeps = long{settings.substeps} * (settings.iterations + settings.relax_iterations);
  if (world.body_count() > 200 || sweeps > 500) return;
  for (int i = 0; i < steps; ++i) {
    world.step(1.0 / 60);
    check_world(world);
  }
}

}  // namespace atl::fuzz
