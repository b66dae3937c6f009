#pragma once

#include <collision/broadphase/pair.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstddef>
#include <vector>

namespace atl::collision {

/// Set of pairs with constant-time lookup: open addressing, linear probing, at most half full. Only ever asked
/// whether it has a pair, so its internal order never shows. Concurrent lookups are safe.
class PairSet {
 public:
  bool contains(Pair pair) const;
  void insert(Pair pair);  ///< the pair must not be in it
  void erase(Pair pair);   ///< the pair must be in it
  std::size_t size() const { return size_; }

  /// Drops from `pairs`, from the one at `begin` on, those that are in the set. The others keep their order.
  /// Much faster than one lookup after another, as it fetches ahead.
  void drop_contained(std::vector<Pair>& pairs, std::size_t begin) const;
  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(keys_); }

 private:
  static constexpr std::uint64_t vacant = ~std::uint64_t{0};

  std::size_t home(std::uint64_t key) const;
  std::size_t next(std::size_t slot) const { return (slot + 1) & (keys_.size() - 1); }
  void grow();

  jobs::CompactArray<std::uint64_t> keys_;  // a power of two, or none
  std::size_t size_ = 0;
};

}  // namespace atl::collision
