#include <collision/contacts/contact_cache.h>
#include <jobs/assert.h>

#include <algorithm>

namespace atl::collision {

bool ContactCache::precedes(std::uint32_t a, std::uint32_t b) const {
  const Contact& x = contacts[a];
  const Contact& y = contacts[b];
  return x.pair == y.pair ? x.part < y.part : x.pair < y.pair;
}

void ContactCache::claim_body(std::uint32_t body) {
  if (body < active_.size()) return;
  active_.resize(body + std::size_t{1}, 0);
}

// The first time all room is made at once, since a scene starts with most of its contacts. Later small arrays grow by a
// quarter, since contacts are most of a small world's memory. Large ones grow by more: frequent copies would show in
// the longest step (`pile`: 27 ms instead of 18).
void ContactCache::make_room_for(std::size_t count) {
  ATL_ASSERT(free_slots_.size() <= contacts.size(), free_slots_.size(), contacts.size());
  ATL_ASSERT(manifolds.size() == contacts.size(), manifolds.size(), contacts.size());
  ATL_ASSERT(state_.size() == contacts.size(), state_.size(), contacts.size());
  const std::size_t needed = size() + count;
  if (needed <= contacts.capacity()) return;
  constexpr std::size_t few = 256;
  const std::size_t more = contacts.capacity() < few ? contacts.capacity() / 4 : contacts.capacity();
  const std::size_t room = std::max(needed, contacts.capacity() + more);
  contacts.reserve(room);
  manifolds.reserve(room);
  state_.reserve(room);
  idle_.reserve(room);
  of_body_.reserve(room);
}

std::uint32_t ContactCache::claim_slot() {
  std::uint32_t slot;
  if (free_slots_.empty()) {
    slot = static_cast<std::uint32_t>(contacts.size());
    contacts.emplace_back();
    manifolds.emplace_back();
    state_.emplace_back();
    idle_.add_slot();
    of_body_.resize(contacts.size());
  } else {
    slot = free_slots_.back();
    free_slots_.pop_back();
    ATL_ASSERT(slot < contacts.size(), slot, contacts.size());
    ATL_ASSERT(state_[slot] == ContactState::Free, slot, static_cast<int>(state_[slot]));
  }
  contacts[slot] = Contact{};
  manifolds[slot] = ContactManifold{};
  idle_.mark_all_stale();
  ++changes_;
  return slot;
}

// Enters a contact in the lists of its bodies.
void ContactCache::link(std::uint32_t slot) {
  const Contact& contact = contacts[slot];
  ATL_ASSERT(contact.body_first != contact.body_second, slot, contact.body_first);
  claim_body(contact.body_first);
  claim_body(contact.body_second);
  of_body_.add(slot, contact.body_first, contact.body_second);
  if (is_active(contact)) {
    state_[slot] = ContactState::Active;
  } else {
    set_idle(slot);
  }
}

void ContactCache::set_idle(std::uint32_t slot) {
  ATL_ASSERT(slot < state_.size() && !is_active(contacts[slot]), slot, state_.size());
  state_[slot] = ContactState::Idle;
  idle_.note(slot);
}

// Slots are in no order: what is needed soon is asked of memory now.
void ContactCache::release_all(std::span<const std::uint32_t> slots) {
  constexpr std::size_t ahead = 4;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i + ahead < slots.size()) {
      const std::uint32_t soon = slots[i + ahead];
      __builtin_prefetch(&contacts[soon]);
      of_body_.prefetch(soon);
    }
    release(slots[i]);
  }
}

// Gives up a slot, but for its place in the order.
void ContactCache::release(std::uint32_t slot) {
  ATL_ASSERT(slot < contacts.size(), slot, contacts.size());
  ATL_ASSERT(state_[slot] != ContactState::Free, slot);
  of_body_.remove(slot, contacts[slot].body_first, contacts[slot].body_second);
  if (contacts[slot].part == 0) pairs.erase(contacts[slot].pair);
  state_[slot] = ContactState::Free;
  free_slots_.push_back(slot);
  idle_.mark_all_stale();
  ++changes_;
}

std::span<const std::uint32_t> ContactCache::set_active(std::span<const std::uint32_t> started,
                                                        std::span<const std::uint32_t> stopped) {
  for (const std::uint32_t body : stopped) {
    claim_body(body);
    active_[body] = 0;
  }
  for (const std::uint32_t body : started) {
    claim_body(body);
    active_[body] = 1;
  }
  if (!stopped.empty()) {
    for (const std::uint32_t slot : order().slots()) {
      if (!is_active(contacts[slot])) set_idle(slot);
    }
    drop_inactive();
  }
  added_.clear();
  for (const std::uint32_t body : started) {
    for_each_contact_of(body, [this](std::uint32_t slot) {
      if (state_[slot] != ContactState::Idle) return;
      state_[slot] = ContactState::Active;
      added_.push_back(slot);
    });
  }
  std::sort(added_.begin(), added_.end(), [this](std::uint32_t a, std::uint32_t b) { return precedes(a, b); });
  merge_into_order();
  return added_;
}

bool ContactCache::touches(Pair pair) const {
  const ContactOrder& all = order();
  for (std::size_t entry = all.first_entry_of(pair); entry < all.size() && all.pair_at(entry) == pair; ++entry) {
    if (contacts[all[entry]].count > 0) return true;
  }
  return false;
}

void ContactCache::merge_into_order() {
  if constexpr (jobs::with_asserts) {
    for (std::size_t i = 0; i < added_.size(); ++i) {
      ATL_ASSERT(state_[added_[i]] == ContactState::Active, i, added_[i]);
      ATL_ASSERT(i == 0 || precedes(added_[i - 1], added_[i]), i, added_[i - 1], added_[i]);
    }
  }
  order_.merge(added_, [this](std::uint32_t slot) { return contacts[slot].pair; });
}

// Takes from the order what is idle or gone by its state.
void ContactCache::drop_inactive() const {
  order_.keep_if([this](std::uint32_t slot) { return state_[slot] == ContactState::Active; });
  order_has_gaps_ = false;
}

void ContactCache::remove_contacts_of(std::uint32_t body) {
  added_.clear();
  for_each_contact_of(body, [this](std::uint32_t slot) { added_.push_back(slot); });
  for (const std::uint32_t slot : added_) {
    order_has_gaps_ = order_has_gaps_ || state_[slot] == ContactState::Active;
    release(slot);
  }
}

std::span<const std::uint32_t> ContactCache::all_in_order() const {
  const ContactOrder& active = order();
  if (active.size() == size()) return active.slots();
  return idle_.with_active(active, contacts, state_);
}

}  // namespace atl::collision
