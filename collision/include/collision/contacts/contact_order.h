#pragma once

#include <collision/broadphase/pair.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace atl::collision {

/// Slots of contacts in the order of their pairs and, of a pair, of its parts. The pairs' keys stand beside: to search
/// them, or to go through the pairs, needn't touch contacts.
class ContactOrder {
 public:
  std::size_t size() const { return slots_.size(); }
  bool empty() const { return slots_.empty(); }
  std::uint32_t operator[](std::size_t entry) const { return slots_[entry]; }
  std::span<const std::uint32_t> slots() const { return slots_; }
  Pair pair_at(std::size_t entry) const { return Pair::of_key(keys_[entry]); }

  /// The first entry of a pair, or where it would be. In logarithmic time.
  std::size_t first_entry_of(Pair pair) const {
    return static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), pair.key()) - keys_.begin());
  }
  /// The entry after the parts of a pair.
  std::size_t pair_end(std::size_t entry) const {
    std::size_t end = entry + 1;
    while (end < keys_.size() && keys_[end] == keys_[entry]) ++end;
    return end;
  }

  /// Adds slots, which are in order; pair_of(slot) is asked of each.
  template <typename PairOf>
  void merge(std::span<const std::uint32_t> added, const PairOf& pair_of) {
    // From the back, so that nothing is overwritten before it has moved.
    std::size_t old_left = slots_.size();
    slots_.resize(old_left + added.size());
    keys_.resize(slots_.size());
    for (std::size_t added_left = added.size(); added_left > 0; --added_left) {
      const std::uint64_t key = pair_of(added[added_left - 1]).key();
      for (; old_left > 0 && keys_[old_left - 1] > key; --old_left) {
        slots_[old_left + added_left - 1] = slots_[old_left - 1];
        keys_[old_left + added_left - 1] = keys_[old_left - 1];
      }
      slots_[old_left + added_left - 1] = added[added_left - 1];
      keys_[old_left + added_left - 1] = key;
    }
  }

  /// Drops the slots for which keep(slot) does not hold.
  template <typename Keep>
  void keep_if(const Keep& keep) {
    std::size_t kept = 0;
    for (std::size_t entry = 0; entry < slots_.size(); ++entry) {
      if (!keep(slots_[entry])) continue;
      slots_[kept] = slots_[entry];
      keys_[kept++] = keys_[entry];
    }
    slots_.resize(kept);
    keys_.resize(kept);
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(slots_, keys_); }

 private:
  jobs::CompactArray<std::uint32_t> slots_;
  jobs::CompactArray<std::uint64_t> keys_;  // by entry
};

}  // namespace atl::collision
