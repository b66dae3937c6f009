#pragma once

#include <cstdint>

namespace atl::collision {

/// Says which shapes a shape may meet. Category and mask are sets of bits, as in most engines: two shapes may
/// meet if each one's mask has a bit of the other's category.
struct Filter {
  /// As an owner: the shape itself, which then shares it with no other.
  static constexpr std::uint32_t own_shape = ~std::uint32_t{0};

  std::uint32_t category = 1;
  std::uint32_t mask = ~std::uint32_t{0};
  /// Two shapes of the same group that is not 0 always meet if it is positive, never if it is negative.
  std::int32_t group = 0;
  /// Usually the body's number: shapes of one owner never meet, whatever their group.
  std::uint32_t owner = own_shape;

  friend bool operator==(const Filter&, const Filter&) = default;
};

/// Whether two shapes may meet; both owners must be given. Symmetric.
inline bool may_meet(const Filter& a, const Filter& b) {
  if (a.owner == b.owner) return false;
  if (a.group == b.group && a.group != 0) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

/// Whether there is nothing that the shape may meet.
inline bool meets_nothing(const Filter& filter) {
  return filter.group <= 0 && (filter.mask == 0 || filter.category == 0);
}

}  // namespace atl::collision
