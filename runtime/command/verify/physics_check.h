#pragma once

#include "verify_options.h"

namespace atl::command {

/// Runs the suite of physical laws, or the cases that were chosen, and prints what each came to. Throws Failure, with
/// Status::CheckFailed where one is not as it should be.
void check_physics(const VerifyOptions& options);

}  // namespace atl::command
