#pragma once

#include <solver/select/load_estimate.h>

#include <cstddef>

namespace atl::solver {

/// True if a body that is alone on its island leans on one thing and lands on another in this step: a block that rocks
/// from edge to edge, a ball that rolls into a wall.
///
/// A new contact stops the body for the whole substep in which it is reached, and the old contact lets go for the whole
/// of it. So a landing has an error of the weight's impulse in a substep: first order, while all else is second order.
bool lands(const LoadInput& input, std::size_t island);

}  // namespace atl::solver
