#pragma once

#include "verify_options.h"

namespace atl::command {

/// `atoll verify`: runs checks and prints what each came to. Throws Failure, with Status::CheckFailed where one fails
/// that is not known to.
void verify(const VerifyOptions& options);

}  // namespace atl::command
