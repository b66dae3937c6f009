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

void ContactCache::merge_into_order(std::size_t old_count) {
  std::inplace_merge(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(old_count), order.end(),
                     [this](std::uint32_t a, std::uint32_t b) { return contacts[a].pair < contacts[b].pair; });
}

}  // namespace atl::collision
