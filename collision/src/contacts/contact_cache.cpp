#include <collision/contacts/contact_cache.h>

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

// At once, as a scene starts with most of its contacts.
void ContactCache::make_room_for(std::size_t count) {
  const std::size_t needed = size() + count;
  if (needed <= contacts.capacity()) return;
  const std::size_t room = std::max(needed, 2 * contacts.capacity());
  contacts.reserve(room);
  manifolds.reserve(room);
  state_.reserve(room);
  is_newly_idle_.reserve(room);
  of_body_.reserve(room);
}

std::uint32_t ContactCache::claim_slot() {
  std::uint32_t slot;
  if (free_slots.empty()) {
    slot = static_cast<std::uint32_t>(contacts.size());
    contacts.emplace_back();
    manifolds.emplace_back();
    state_.emplace_back();
    is_newly_idle_.emplace_back();
    of_body_.resize(contacts.size());
  } else {
    slot = free_slots.back();
    free_slots.pop_back();
  }
  contacts[slot] = Contact{};
  manifolds[slot] = ContactManifold{};
  all_stale_ = true;
  return slot;
}

// Enters a contact in the lists of its bodies.
void ContactCache::link(std::uint32_t slot) {
  const Contact& contact = contacts[slot];
  claim_body(contact.body_first);
  claim_body(contact.body_second);
  of_body_.add(slot, contact.body_first, contact.body_second);
  if (is_active(contact)) {
    state_[slot] = State::Active;
  } else {
    note_idle(slot);
  }
}

void ContactCache::note_idle(std::uint32_t slot) {
  state_[slot] = State::Idle;
  if (is_newly_idle_[slot]) return;
  is_newly_idle_[slot] = 1;
  newly_idle_.push_back(slot);
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
  of_body_.remove(slot, contacts[slot].body_first, contacts[slot].body_second);
  if (contacts[slot].part == 0) pairs.erase(contacts[slot].pair);
  state_[slot] = State::Free;
  free_slots.push_back(slot);
  all_stale_ = true;
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
    for (const std::uint32_t slot : order) {
      if (!is_active(contacts[slot])) note_idle(slot);
    }
    drop_inactive();
  }
  added_.clear();
  for (const std::uint32_t body : started) {
    for_each_contact_of(body, [this](std::uint32_t slot) {
      if (state_[slot] != State::Idle) return;
      state_[slot] = State::Active;
      added_.push_back(slot);
    });
  }
  std::sort(added_.begin(), added_.end(), [this](std::uint32_t a, std::uint32_t b) { return precedes(a, b); });
  merge_into_order();
  return added_;
}

bool ContactCache::touches(Pair pair) const {
  for (std::size_t entry = first_entry_of(pair); entry < order.size() && keys_[entry] == pair.key(); ++entry) {
    if (contacts[order[entry]].count > 0) return true;
  }
  return false;
}

std::size_t ContactCache::first_entry_of(Pair pair) const {
  return static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), pair.key()) - keys_.begin());
}

// Takes from the order what is idle or gone by its state.
void ContactCache::drop_inactive() {
  std::size_t kept = 0;
  for (std::size_t entry = 0; entry < order.size(); ++entry) {
    if (state_[order[entry]] != State::Active) continue;
    order[kept] = order[entry];
    keys_[kept++] = keys_[entry];
  }
  order.resize(kept);
  keys_.resize(kept);
}

void ContactCache::remove_contacts_of(std::uint32_t body) {
  added_.clear();
  for_each_contact_of(body, [this](std::uint32_t slot) { added_.push_back(slot); });
  for (const std::uint32_t slot : added_) {
    if (state_[slot] == State::Active) {
      std::size_t entry = first_entry_of(contacts[slot].pair);
      while (order[entry] != slot) ++entry;
      order.erase(order.begin() + static_cast<std::ptrdiff_t>(entry));
      keys_.erase(keys_.begin() + static_cast<std::ptrdiff_t>(entry));
    }
    release(slot);
  }
}

// Both parts are in order. From the back, so that nothing is overwritten before it has moved.
void ContactCache::merge_into_order() {
  std::size_t old_left = order.size();
  order.resize(old_left + added_.size());
  keys_.resize(order.size());
  for (std::size_t added_left = added_.size(); added_left > 0; --added_left) {
    const std::uint64_t key = contacts[added_[added_left - 1]].pair.key();
    for (; old_left > 0 && keys_[old_left - 1] > key; --old_left) {
      order[old_left + added_left - 1] = order[old_left - 1];
      keys_[old_left + added_left - 1] = keys_[old_left - 1];
    }
    order[old_left + added_left - 1] = added_[added_left - 1];
    keys_[old_left + added_left - 1] = key;
  }
}

// A slot may have been given up and used again for another pair.
void ContactCache::update_idle() const {
  const auto is_idle = [this](std::uint32_t slot) { return state_[slot] == State::Idle; };
  std::erase_if(idle_, [&](const Entry& entry) { return !is_idle(entry.slot) || is_newly_idle_[entry.slot] != 0; });
  const auto kept = static_cast<std::ptrdiff_t>(idle_.size());
  for (const std::uint32_t slot : newly_idle_) {
    is_newly_idle_[slot] = 0;
    if (is_idle(slot)) idle_.push_back({contacts[slot].pair.key(), contacts[slot].part, slot});
  }
  newly_idle_.clear();
  const auto precedes = [](const Entry& a, const Entry& b) { return a.key == b.key ? a.part < b.part : a.key < b.key; };
  std::sort(idle_.begin() + kept, idle_.end(), precedes);
  std::inplace_merge(idle_.begin(), idle_.begin() + kept, idle_.end(), precedes);
}

std::span<const std::uint32_t> ContactCache::all_in_order() const {
  if (order.size() == size()) return order;
  if (!all_stale_) return all_;
  update_idle();
  all_.clear();
  std::size_t entry = 0;
  for (const Entry& idle : idle_) {
    while (entry < order.size() && keys_[entry] < idle.key) all_.push_back(order[entry++]);
    all_.push_back(idle.slot);
  }
  all_.insert(all_.end(), order.begin() + static_cast<std::ptrdiff_t>(entry), order.end());
  all_stale_ = false;
  return all_;
}

}  // namespace atl::collision
