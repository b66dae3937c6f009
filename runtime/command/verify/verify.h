#pragma once

#include "checks/divergence/variant_run.h"
#include "verify_options.h"

namespace atl::command {

/// `atoll verify`: runs checks and prints what each came to. Throws Failure, with Status::CheckFailed where one fails
/// that is not known to. Tests meddle with runs, to see that it is found out.
void verify(const VerifyOptions& options, const divergence::Meddle& meddle = {});

}  // namespace atl::command
