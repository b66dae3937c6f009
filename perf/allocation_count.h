#pragma once

#include <cstdint>

/// Calls of operator new in this program so far, those of containers among them. Linking this replaces the operators.
std::int64_t allocation_count();
/// Allocations whose memory has not been given back.
std::int64_t live_allocations();

/// Has memory run out as long as this lives, after so many more allocations: for one of them, or for good.
class OutOfMemory {
 public:
  OutOfMemory(std::int64_t after, bool for_good);
  ~OutOfMemory();
  OutOfMemory(const OutOfMemory&) = delete;
  OutOfMemory& operator=(const OutOfMemory&) = delete;
  /// True once an allocation has failed.
  static bool happened();
};
