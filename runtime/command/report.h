#pragma once

#include <atoll/world.h>

#include <iosfwd>

#include "simulation.h"

namespace atl::command {

/// The results to be read by people.
void write_text(std::ostream& out, const Scene& scene, const World& world, const RunResult& result);
/// The results as one JSON object, whose keys and their order are part of the command's interface.
void write_json(std::ostream& out, const Scene& scene, const World& world, const RunResult& result);

}  // namespace atl::command
