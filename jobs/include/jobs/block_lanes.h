#pragma once

#include <cstddef>

namespace atl::jobs {

/// Items that a wide kernel works on together, whatever the width of the machine's vectors: so no result depends
/// on it.
inline constexpr std::size_t block_lanes = 8;

}  // namespace atl::jobs
