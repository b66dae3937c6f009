#pragma once

#include "checks/divergence/variant_run.h"
#include "verify_options.h"

namespace atl::command {

/// Runs the scene once, and again with every other combination of threads, instruction set and restoring that was asked
/// for, and prints where each parts from the first. Throws Failure, with Status::CheckFailed if one does.
void check_determinism(const VerifyOptions& options, const divergence::Meddle& meddle);

/// Runs the stability suite, or the cases that were chosen, and prints what each came to. Throws Failure, with
/// Status::CheckFailed where one fails that is not known to.
void check_stability(const VerifyOptions& options);

/// Runs the suite of physical laws, or the cases that were chosen, and prints what each came to. Throws Failure, with
/// Status::CheckFailed where one is not as it should be.
void check_physics(const VerifyOptions& options);

}  // namespace atl::command
