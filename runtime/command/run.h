#pragma once

#include "run_options.h"

namespace atl::command {

/// `atoll run`: loads, simulates, reports. Throws SceneError and Failure.
void run(const RunOptions& options);

}  // namespace atl::command
