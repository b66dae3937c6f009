#pragma once

#include <cstdint>

namespace atl::collision {

/// A contact with points, of which at least one body is dynamic: the bodies, first and second as in Contact, and the
/// contact's slot.
struct TouchingPair {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t slot;
};

}  // namespace atl::collision
