#pragma once

#include "replay_options.h"

namespace atl::command {

/// `atoll replay`: makes a recording's calls again and prints whether that came to the same. Throws Failure, with
/// Status::CheckFailed if it did not and Status::BadScene if the file can't be replayed.
void replay_file(const ReplayFileOptions& options);

}  // namespace atl::command
