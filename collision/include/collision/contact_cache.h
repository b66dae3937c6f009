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

  /// What a contact starts with.
  struct Start {
    std::uint32_t body_first;
    std::uint32_t body_second;
    float friction;
    float restitution;
    float size;   ///< m, of the smaller shape, see Contact
    bool placed;  ///< see Contact
    int parts;    ///< contacts that the pair needs: more than one only of a solid and a surface
  };

  /// Adds contacts without points for pairs, which are in order and not in the cache. `start(pair)` gives Start.
  template <typename StartOf>
  void add(std::span<const Pair> fresh, const StartOf& start_of);

  /// Whether a pair has contact points. In time logarithmic in the number of contacts.
  bool touches(Pair pair) const;

  /// Removes the contacts for which gone(slot) holds: of a pair, all parts or none.
  template <typename Gone>
  void remove_if(const Gone& gone);

 private:
  std::uint32_t claim_slot();
  void merge_into_order(std::size_t old_count);

  std::vector<std::uint32_t> added_;  // scratch
};

template <typename StartOf>
void ContactCache::add(std::span<const Pair> fresh, const StartOf& start_of) {
  const std::size_t old_count = order.size();
  for (const Pair pair : fresh) {
    const Start start = start_of(pair);
    for (int part = 0; part < start.parts; ++part) {
      const std::uint32_t slot = claim_slot();
      contacts[slot].pair = pair;
      contacts[slot].body_first = start.body_first;
      contacts[slot].body_second = start.body_second;
      contacts[slot].size = start.size;
      contacts[slot].placed = start.placed;
      contacts[slot].part = static_cast<std::uint8_t>(part);
      manifolds[slot].friction = start.friction;
      manifolds[slot].restitution = start.restitution;
      order.push_back(slot);
    }
    pairs.insert(pair);
  }
  merge_into_order(old_count);
}

template <typename Gone>
void ContactCache::remove_if(const Gone& gone) {
  std::size_t kept = 0;
  for (const std::uint32_t slot : order) {
    if (gone(slot)) {
      if (contacts[slot].part == 0) pairs.erase(contacts[slot].pair);
      free_slots.push_back(slot);
    } else {
      order[kept++] = slot;
    }
  }
  order.resize(kept);
}

}  // namespace atl::collision
