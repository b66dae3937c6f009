#pragma once

#include <collision/broadphase/pair_set.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstdint>

namespace atl::collision {

/// Says which shapes a shape may meet. Category and mask are sets of bits, as in most engines: two shapes may
/// meet if each one's mask has a bit of the other's category.
struct Filter {
  /// Value of `owner` for a shape that is its own owner, and shares it with no other shape.
  static constexpr std::uint32_t own_shape = ~std::uint32_t{0};

  std::uint32_t category = 1;
  std::uint32_t mask = ~std::uint32_t{0};
  /// Two shapes of the same group that is not 0 always meet if it is positive, never if it is negative.
  std::int32_t group = 0;
  /// Usually the body's number: shapes of one owner never meet, whatever their group.
  std::uint32_t owner = own_shape;

  friend bool operator==(const Filter&, const Filter&) = default;
};

/// True if two shapes may meet by their filters. The owners of both must be set. Symmetric.
inline bool may_meet(const Filter& a, const Filter& b) {
  if (a.owner == b.owner) return false;
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

/// True if the filter excludes contact with every other shape.
inline bool meets_nothing(const Filter& filter) {
  return filter.group <= 0 && (filter.mask == 0 || filter.category == 0);
}

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

  /// True if two shapes may meet. Most shapes are unrestricted, and one byte for each of the two settles it.
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

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(entries_, restricted_, owners_, disabled_); }

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

  jobs::CompactArray<Entry> entries_;  // by shape
  // By shape: 1 if its filter is not the default one, or its owner has disabled pairs.
  jobs::CompactArray<std::uint8_t> restricted_;
  jobs::CompactArray<Owner> owners_;  // by number
  PairSet disabled_;                  // of owners
};

}  // namespace atl::collision
