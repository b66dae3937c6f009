#include <algorithm>

#include "world_impl.h"

namespace atl {
namespace {

// Speculative points count from when they carry something.
bool touches(const collision::Contact& contact, const collision::ContactManifold& manifold) {
  for (std::size_t i = 0; i < contact.count; ++i) {
    if (manifold.separation[i] <= 0 || manifold.normal_impulse[i] > 0) return true;
  }
  return false;
}

}  // namespace

// Bodies may have several contacts with each other, so what counts is the list of bodies that touch. Of two bodies all
// contacts are idle or none is, and idle ones touch as they did.
void World::Impl::note_events() {
  contact_events_.clear();
  if (events_noted_ && !islands_rebuilt_ && cache.order.empty()) return;
  const auto id = [this](std::uint32_t body) { return BodyId{body, records.generation[body]}; };
  const auto is_idle = [&](const std::pair<BodyId, BodyId>& pair) {
    const auto [a, b] = pair;
    return !active_.contains(a.index) && !active_.contains(b.index) && records.alive[a.index] &&
           records.alive[b.index] && a == id(a.index) && b == id(b.index) && !quarantine.contains(a.index) &&
           !quarantine.contains(b.index);
  };
  std::swap(touched_, touched_before_);
  touched_now_.clear();
  if (!events_noted_) place_idle_contacts();
  for (const std::uint32_t slot : events_noted_ ? std::span<const std::uint32_t>(cache.order) : cache.all_in_order()) {
    const collision::Contact& contact = cache.contacts[slot];
    if (!touches(contact, cache.manifolds[slot])) continue;
    const auto [a, b] = std::minmax(contact.body_first, contact.body_second);
    touched_now_.emplace_back(id(a), id(b));
  }
  std::sort(touched_now_.begin(), touched_now_.end());
  touched_now_.erase(std::unique(touched_now_.begin(), touched_now_.end()), touched_now_.end());

  touched_.clear();
  auto active = touched_now_.begin();
  if (events_noted_) {
    for (const std::pair<BodyId, BodyId>& pair : touched_before_) {
      if (!is_idle(pair)) continue;
      while (active != touched_now_.end() && *active < pair) touched_.push_back(*active++);
      touched_.push_back(pair);
    }
  }
  touched_.insert(touched_.end(), active, touched_now_.end());

  auto before = touched_before_.begin();
  auto now = touched_.begin();
  while (before != touched_before_.end() || now != touched_.end()) {
    if (now == touched_.end() || (before != touched_before_.end() && *before < *now)) {
      contact_events_.push_back({before->first, before->second, false});
      ++before;
    } else if (before == touched_before_.end() || *now < *before) {
      contact_events_.push_back({now->first, now->second, true});
      ++now;
    } else {
      ++before;
      ++now;
    }
  }
}

}  // namespace atl
