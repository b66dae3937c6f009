#pragma once

#include <collision/contact.h>
#include <collision/pair_set.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// All contacts of a world, kept from step to step with their manifolds and impulses. A contact has a slot
/// for its lifetime; `order` lists the slots in order of pairs, which is the order of everything that is
/// done to contacts.
struct ContactCache {
  std::vector<Contact> contacts;           ///< by slot
  std::vector<ContactManifold> manifolds;  ///< by slot
  std::vector<std::uint32_t> order;        ///< slots in use
  std::vector<std::uint32_t> free_slots;   ///< the last is used first
  PairSet pairs;                           ///< those in `order`

  /// Adds contacts without points for pairs, which are in order and not in the cache.
  /// `material(pair)` gives {friction, restitution} of a pair.
  template <typename Material>
  void add(std::span<const Pair> fresh, const Material& material);

  /// Removes the contacts for which gone(slot) holds.
  template <typename Gone>
  void remove_if(const Gone& gone);

 private:
  std::uint32_t claim_slot();
  void merge_into_order(std::size_t old_count);
};

template <typename Material>
void ContactCache::add(std::span<const Pair> fresh, const Material& material) {
  const std::size_t old_count = order.size();
  for (const Pair pair : fresh) {
    const std::uint32_t slot = claim_slot();
    contacts[slot].pair = pair;
    const auto [friction, restitution] = material(pair);
    manifolds[slot].friction = friction;
    manifolds[slot].restitution = restitution;
    order.push_back(slot);
    pairs.insert(pair);
  }
  merge_into_order(old_count);
}

template <typename Gone>
void ContactCache::remove_if(const Gone& gone) {
  std::size_t kept = 0;
  for (const std::uint32_t slot : order) {
    if (gone(slot)) {
      pairs.erase(contacts[slot].pair);
      free_slots.push_back(slot);
    } else {
      order[kept++] = slot;
    }
  }
  order.resize(kept);
}

}  // namespace atl::collision
