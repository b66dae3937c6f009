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
    std::erase_if(order, [this](std::uint32_t slot) {
      if (is_active(contacts[slot])) return false;
      state_[slot] = State::Idle;
      return true;
    });
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
  auto entry = std::lower_bound(order.begin(), order.end(), pair,
                                [this](std::uint32_t slot, Pair p) { return contacts[slot].pair < p; });
  for (; entry != order.end() && contacts[*entry].pair == pair; ++entry) {
    if (contacts[*entry].count > 0) return true;
  }
  return false;
}

void ContactCache::remove_contacts_of(std::uint32_t body) {
  added_.clear();
  for_each_contact_of(body, [this](std::uint32_t slot) { added_.push_back(slot); });
  for (const std::uint32_t slot : added_) {
    if (state_[slot] == State::Active) {
      order.erase(std::lower_bound(order.begin(), order.end(), slot,
                                   [this](std::uint32_t a, std::uint32_t b) { return precedes(a, b); }));
    }
    release(slot);
  }
}

// Both parts are in order. From the back, so that nothing is overwritten before it has moved.
void ContactCache::merge_into_order() {
  std::size_t old_left = order.size();
  std::size_t added_left = added_.size();
  order.resize(old_left + added_left);
  while (added_left > 0) {
    const std::uint32_t added = added_[added_left - 1];
    const bool old_is_later = old_left > 0 && contacts[added].pair < contacts[order[old_left - 1]].pair;
    order[old_left + added_left - 1] = old_is_later ? order[old_left - 1] : added;
    --(old_is_later ? old_left : added_left);
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
