#pragma once

namespace atl {

/// s; the ends of a step's range. A substep is a part of up to 1024 of it, of which single precision has to hold the
/// square and the inverse.
inline constexpr double shortest_step = 1e-12;
inline constexpr double longest_step = 1;

}  // namespace atl
