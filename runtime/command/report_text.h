#pragma once

#include <atoll/world.h>

#include <iosfwd>

#include "simulation.h"

namespace atl::command {

/// The results to be read by people.
void write_text(std::ostream& out, const Scene& scene, const World& world, const RunResult& result);

}  // namespace atl::command
