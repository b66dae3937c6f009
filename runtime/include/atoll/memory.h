#pragma once

#include <cstddef>

namespace atl {

/// A part of a world's memory: see World::memory(). A part that nothing in the scene uses, and that no step has needed,
/// holds nothing. Memory that a thread keeps for the steps it makes is no world's.
struct MemoryUse {
  const char* name;   ///< "bodies", "contacts", ...
  std::size_t bytes;  ///< held, used or not
  std::size_t count;  ///< of what it is for
  const char* unit;   ///< of these, as "bodies"
};

}  // namespace atl
