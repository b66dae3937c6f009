#pragma once

#include "checks/divergence/variant_run.h"
#include "verify_options.h"

namespace atl::command {

/// Runs the scene once, and again with every other combination of threads, instruction set and restoring that was asked
/// for, and prints where each parts from the first. Throws Failure, with Status::CheckFailed if one does.
void check_determinism(const VerifyOptions& options, const divergence::Meddle& meddle);

}  // namespace atl::command
