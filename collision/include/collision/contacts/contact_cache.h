#pragma once

#include <collision/broadphase/pair_set.h>
#include <collision/contacts/contact.h>
#include <collision/contacts/contact_order.h>
#include <collision/contacts/idle_contacts.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <jobs/pair_lists.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>

namespace atl::collision {

/// All contacts of a world, kept from step to step with their manifolds and impulses. A contact has a slot for its
/// lifetime. Contacts with an active body are in order(), sorted by pair, and everything is done to contacts in this
/// order. The others are idle: nothing visits them until one of their bodies becomes active or goes.
class ContactCache {
 public:
  jobs::CompactArray<Contact> contacts;           ///< by slot
  jobs::CompactArray<ContactManifold> manifolds;  ///< by slot
  /// The gain (m, by slot) of a smooth surface along the normal in half a step, see collide_surface(). Empty while
  /// there is none.
  jobs::CompactArray<float> rises;
  PairSet pairs;  ///< of all contacts, idle ones too

  /// The values that a new contact starts with.
  struct Start {
    std::uint32_t body_first;
    std::uint32_t body_second;
    float friction;
    float restitution;
    float size;             ///< m, of the smaller shape, see Contact
    bool has_local_offset;  ///< see Contact
    int parts;              ///< contacts that the pair needs: more than one only of a solid and a surface
  };

  /// Adds contacts without points for pairs, which are in order and not in the cache. `start_of(pair)` gives Start.
  template <typename StartOf>
  void add(std::span<const Pair> new_pairs, const StartOf& start_of);

  /// Bodies that have become active, or ceased to be; before the first call none are. Returns the slots of contacts
  /// that were idle and are active now, in order, valid until the next change. The cost follows the contacts of
  /// what becomes active, and the active ones.
  std::span<const std::uint32_t> set_active(std::span<const std::uint32_t> started,
                                            std::span<const std::uint32_t> stopped);

  /// The active contacts. The first call after bodies went costs as much as there are contacts.
  const ContactOrder& order() const {
    if (order_has_gaps_) drop_inactive();
    return order_;
  }
  /// True if a pair with an active body has contact points. Takes time logarithmic in the number of active contacts.
  bool touches(Pair pair) const;

  /// Removes the active contacts for which gone(slot) holds, asked in order: of a pair, all parts or none.
  template <typename Gone>
  void remove_if(const Gone& gone);

  /// The same of all contacts, idle or not.
  template <typename Gone>
  void remove_any_if(const Gone& gone);

  /// Removes the contacts of a body, idle or not. The cost is that of its own contacts.
  void remove_contacts_of(std::uint32_t body);

  /// Calls visit(slot) for the contacts of a body, idle or not, in no order to rely on.
  template <typename Visit>
  void for_each_contact_of(std::uint32_t body, const Visit& visit) const {
    of_body_.for_each_of(body, visit);
  }

  std::size_t size() const { return contacts.size() - free_slots_.size(); }
  /// A count that changes whenever contacts come or go; slots listed before then may be those of other contacts.
  std::uint64_t changes() const { return changes_; }

  /// All slots in use, of idle contacts too, in order. If some are idle and any came or went since the last call the
  /// cost is linear in their number, and that of sorting in the number that became idle. Valid until the next change.
  std::span<const std::uint32_t> all_in_order() const;

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(contacts, manifolds, rises, free_slots_, state_, active_, added_, gone_, pairs, order_, of_body_,
                    idle_);
  }

 private:
  bool is_active(const Contact& contact) const {
    return active_[contact.body_first] != 0 || active_[contact.body_second] != 0;
  }
  bool precedes(std::uint32_t a, std::uint32_t b) const;
  void make_room_for(std::size_t count);
  void claim_body(std::uint32_t body);
  std::uint32_t claim_slot();
  void link(std::uint32_t slot);
  void set_idle(std::uint32_t slot);
  template <typename Gone>
  void release_of(std::span<const std::uint32_t> slots, const Gone& gone);
  void release_all(std::span<const std::uint32_t> slots);
  void release(std::uint32_t slot);
  void merge_into_order();
  void drop_inactive() const;

  // Lists the members that last from step to step, then (after the empty comment) scratch. A new member has to be put
  // into one of the two lists, or this doesn't compile.
  static void check_members(ContactCache& cache) {
    auto& [contacts, manifolds, pairs, /**/ rises, free_slots, order, gaps, state, of_body, active, added, gone, idle,
           changes] = cache;
    static_cast<void>(contacts);
  }

  jobs::CompactArray<std::uint32_t> free_slots_;  // the last is used first
  mutable ContactOrder order_;
  mutable bool order_has_gaps_ = false;     // slots in it are free, and must not be used again before they are dropped
  jobs::CompactArray<ContactState> state_;  // by slot
  jobs::PairLists of_body_;
  jobs::CompactArray<std::uint8_t> active_;  // by body
  jobs::CompactArray<std::uint32_t> added_;  // scratch: slots, in order
  jobs::CompactArray<std::uint32_t> gone_;   // scratch: slots, in order
  mutable IdleContacts idle_;                // sorted when somebody asks
  std::uint64_t changes_ = 0;
};

template <typename StartOf>
void ContactCache::add(std::span<const Pair> new_pairs, const StartOf& start_of) {
  order();
  added_.clear();
  make_room_for(new_pairs.size());
  for (const Pair pair : new_pairs) {
    const Start start = start_of(pair);
    for (int part = 0; part < start.parts; ++part) {
      const std::uint32_t slot = claim_slot();
      contacts[slot].pair = pair;
      contacts[slot].body_first = start.body_first;
      contacts[slot].body_second = start.body_second;
      contacts[slot].size = start.size;
      contacts[slot].has_local_offset = start.has_local_offset;
      contacts[slot].part = static_cast<std::uint8_t>(part);
      manifolds[slot].friction = start.friction;
      manifolds[slot].restitution = start.restitution;
      link(slot);
      if (state_[slot] == ContactState::Active) added_.push_back(slot);
    }
    pairs.insert(pair);
  }
  merge_into_order();
}

template <typename Gone>
void ContactCache::remove_if(const Gone& gone) {
  release_of(order().slots(), gone);
}

template <typename Gone>
void ContactCache::remove_any_if(const Gone& gone) {
  release_of(all_in_order(), gone);
}

template <typename Gone>
void ContactCache::release_of(std::span<const std::uint32_t> slots, const Gone& gone) {
  gone_.clear();
  std::copy_if(slots.begin(), slots.end(), std::back_inserter(gone_), gone);
  release_all(gone_);
  drop_inactive();
}

}  // namespace atl::collision
