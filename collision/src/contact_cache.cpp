#include <collision/contact_cache.h>

#include <algorithm>

namespace atl::collision {

std::uint32_t ContactCache::claim_slot() {
  std::uint32_t slot;
  if (free_slots.empty()) {
    slot = static_cast<std::uint32_t>(contacts.size());
    contacts.emplace_back();
    manifolds.emplace_back();
  } else {
    slot = free_slots.back();
    free_slots.pop_back();
  }
  contacts[slot] = Contact{};
  manifolds[slot] = ContactManifold{};
  return slot;
}

bool ContactCache::touches(Pair pair) const {
  auto entry = std::lower_bound(order.begin(), order.end(), pair,
                                [this](std::uint32_t slot, Pair p) { return contacts[slot].pair < p; });
  for (; entry != order.end() && contacts[*entry].pair == pair; ++entry) {
    if (contacts[*entry].count > 0) return true;
  }
  return false;
}

// Both parts are in order. From the back, so that nothing is overwritten before it has moved.
void ContactCache::merge_into_order(std::size_t old_count) {
  added_.assign(order.begin() + static_cast<std::ptrdiff_t>(old_count), order.end());
  std::size_t old_left = old_count;
  std::size_t added_left = added_.size();
  while (added_left > 0) {
    const std::uint32_t added = added_[added_left - 1];
    const bool old_is_later = old_left > 0 && contacts[added].pair < contacts[order[old_left - 1]].pair;
    order[old_left + added_left - 1] = old_is_later ? order[old_left - 1] : added;
    --(old_is_later ? old_left : added_left);
  }
}

}  // namespace atl::collision
