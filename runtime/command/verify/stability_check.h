#pragma once

#include "verify_options.h"

namespace atl::command {

/// Runs the stability suite, or the cases that were chosen, and prints what each came to. Throws Failure, with
/// Status::CheckFailed where one fails that is not known to.
void check_stability(const VerifyOptions& options);

}  // namespace atl::command
