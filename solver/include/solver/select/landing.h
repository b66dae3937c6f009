#pragma once

#include <solver/select/load_estimate.h>

#include <cstddef>

namespace atl::solver {

/// Whether a body that is alone on its island leans on something and lands on something else in this step: a block that
/// rocks from edge to edge, a ball that rolls into a wall.
///
/// What is reached within a substep stops it for all of that, and what held it until then lets go for all of it: a
/// landing is off by what its weight does in a substep, of first order where all else is of second.
bool lands(const LoadInput& input, std::size_t island);

}  // namespace atl::solver
