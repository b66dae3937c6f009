#include <collision/contact_cache.h>

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
  first_end_.resize(body + std::size_t{1}, none);
}

// At once, as a scene starts with most of its contacts.
void ContactCache::make_room_for(std::size_t count) {
  const std::size_t needed = size() + count;
  if (needed <= contacts.capacity()) return;
  const std::size_t room = std::max(needed, 2 * contacts.capacity());
  contacts.reserve(room);
  manifolds.reserve(room);
  state_.reserve(room);
  links_.reserve(2 * room);
}

std::uint32_t ContactCache::claim_slot() {
  std::uint32_t slot;
  if (free_slots.empty()) {
    slot = static_cast<std::uint32_t>(contacts.size());
    contacts.emplace_back();
    manifolds.emplace_back();
    state_.emplace_back();
    links_.resize(2 * contacts.size());
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
  for (const std::uint32_t end : {2 * slot, 2 * slot + 1}) {
    const std::uint32_t body = body_of(end);
    claim_body(body);
    const std::uint32_t next = first_end_[body];
    links_[end] = {next, none};
    if (next != none) links_[next].previous = end;
    first_end_[body] = end;
  }
  state_[slot] = is_active(contacts[slot]) ? State::Active : State::Idle;
}

// Gives up a slot, but for its place in the order.
void ContactCache::release(std::uint32_t slot) {
  for (const std::uint32_t end : {2 * slot, 2 * slot + 1}) {
    const Link link = links_[end];
    if (link.next != none) links_[link.next].previous = link.previous;
    (link.previous != none ? links_[link.previous].next : first_end_[body_of(end)]) = link.next;
  }
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
      if (!is_active(contacts[slot])) state_[slot] = State::Idle;
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

std::span<const std::uint32_t> ContactCache::all_in_order() const {
  if (order.size() == size()) return order;
  if (all_stale_) {
    all_.clear();
    for (std::uint32_t slot = 0; slot < state_.size(); ++slot) {
      if (state_[slot] != State::Free) all_.push_back(slot);
    }
    std::sort(all_.begin(), all_.end(), [this](std::uint32_t a, std::uint32_t b) { return precedes(a, b); });
    all_stale_ = false;
  }
  return all_;
}

}  // namespace atl::collision
