#pragma once

#include "sweep_options.h"

namespace atl::command {

/// Runs scenes over the settings of Atoll and of other engines, and writes error against time. Throws Failure and
/// SceneError; the files are written whole at the end, or not at all.
void sweep(const SweepOptions& options);

}  // namespace atl::command
