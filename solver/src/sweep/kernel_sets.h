#pragma once

#include <solver/sweep/kernels.h>

#include <cstdint>

namespace atl::solver {

/// The kernels for an instruction set, by Highway's number for it. Specialised in kernel_set.cpp for each set that the
/// build compiles that file for.
template <std::int64_t set>
const Kernels* kernels_of_set();

}  // namespace atl::solver
