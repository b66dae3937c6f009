#pragma once

#include <atoll/settings.h>
#include <solver/select/error_target.h>
#include <solver/solver_settings.h>
#include <solver/sweep/kernels.h>

namespace atl {

/// Throws Error naming the setting, the value and what was expected.
void check(const Settings& settings);

/// The solver's share of the settings.
solver::SolverSettings solver_settings(const Settings& settings);
solver::ErrorTarget error_target(const ErrorTarget& target);

/// The kernels for an instruction set. Throws Error if this machine lacks it, naming those it has.
const solver::Kernels& kernels_for(Simd simd);
Simd simd_of(const solver::Kernels& kernels);

}  // namespace atl
