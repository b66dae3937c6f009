#pragma once

#include <collision/broadphase/filter.h>
#include <collision/broadphase/pair_set.h>
#include <jobs/bytes.h>

#include <cstdint>
#include <vector>

namespace atl::collision {

/// Says which shapes may meet: by their filters, their owners, and pairs of owners that are disabled.
class CollisionFilters {
 public:
  /// A shape that has no filter yet; the owner is the shape itself if the filter names none.
  void add(std::uint32_t shape, const Filter& filter);
  void remove(std::uint32_t shape);
  void set(std::uint32_t shape, const Filter& filter);
  const Filter& filter(std::uint32_t shape) const { return entries_[shape].filter; }

  /// Shapes of these two owners don't meet, until enabled. Both return whether that is new. Owners may be named before
  /// they have shapes; a disabled pair stays when their shapes go.
  bool disable_pair(std::uint32_t owner_a, std::uint32_t owner_b);
  bool enable_pair(std::uint32_t owner_a, std::uint32_t owner_b);

  /// Whether two shapes may meet. Most shapes are not restricted: of these one byte is read.
  bool allowed(std::uint32_t a, std::uint32_t b) const {
    return (restricted_[a] | restricted_[b]) == 0 ? a != b : filters_allow(a, b);
  }

  /// Calls visit(shape) for the shapes of an owner, which must have been named.
  template <typename Visit>
  void for_each_shape_of(std::uint32_t owner, const Visit& visit) const {
    for (std::uint32_t shape = owners_[owner].first_shape; shape != no_shape; shape = entries_[shape].next_of_owner) {
      visit(shape);
    }
  }

  /// Memory held.
  std::size_t bytes() const { return jobs::bytes_of(entries_, restricted_, owners_) + disabled_.bytes(); }

 private:
  static constexpr std::uint32_t no_shape = ~std::uint32_t{0};

  struct Entry {
    Filter filter;
    // Shapes of the same owner are linked.
    std::uint32_t next_of_owner = no_shape;
    std::uint32_t previous_of_owner = no_shape;
  };

  struct Owner {
    std::uint32_t first_shape = no_shape;
    std::uint32_t disabled_pairs = 0;
  };

  Owner& owner(std::uint32_t number);
  void link(std::uint32_t shape, const Filter& filter);
  void unlink(std::uint32_t shape);
  void update_restricted(std::uint32_t shape);
  void count_disabled(std::uint32_t owner, std::int32_t change);
  bool filters_allow(std::uint32_t a, std::uint32_t b) const;

  std::vector<Entry> entries_;  // by shape
  // By shape: 1 if its filter is not the default one, or its owner has disabled pairs.
  std::vector<std::uint8_t> restricted_;
  std::vector<Owner> owners_;  // by number
  PairSet disabled_;           // of owners
};

}  // namespace atl::collision
