#include <algorithm>

#include "world/world_impl.h"

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
void World::Impl::note_events(ContactEvents& events) {
  events.told.clear();
  if (events.noted && !islands_rebuilt_ && cache.order.empty()) return;
  const auto id = [this](std::uint32_t body) { return BodyId{body, records.generation[body]}; };
  const auto is_idle = [&](const std::pair<BodyId, BodyId>& pair) {
    const auto [a, b] = pair;
    return !active_.contains(a.index) && !active_.contains(b.index) && records.alive[a.index] &&
           records.alive[b.index] && a == id(a.index) && b == id(b.index) && !quarantine.contains(a.index) &&
           !quarantine.contains(b.index);
  };
  std::swap(events.touched, events.before);
  events.now.clear();
  if (!events.noted && settings.contact_events) place_idle_contacts();
  for (const std::uint32_t slot : events.noted ? std::span<const std::uint32_t>(cache.order) : cache.all_in_order()) {
    const collision::Contact& contact = cache.contacts[slot];
    if (!touches(contact, cache.manifolds[slot])) continue;
    const auto [a, b] = std::minmax(contact.body_first, contact.body_second);
    events.now.emplace_back(id(a), id(b));
  }
  std::sort(events.now.begin(), events.now.end());
  events.now.erase(std::unique(events.now.begin(), events.now.end()), events.now.end());

  events.touched.clear();
  auto active = events.now.begin();
  if (events.noted) {
    for (const std::pair<BodyId, BodyId>& pair : events.before) {
      if (!is_idle(pair)) continue;
      while (active != events.now.end() && *active < pair) events.touched.push_back(*active++);
      events.touched.push_back(pair);
    }
  }
  events.touched.insert(events.touched.end(), active, events.now.end());

  auto before = events.before.begin();
  auto now = events.touched.begin();
  while (before != events.before.end() || now != events.touched.end()) {
    if (now == events.touched.end() || (before != events.before.end() && *before < *now)) {
      events.told.push_back({before->first, before->second, false});
      ++before;
    } else if (before == events.before.end() || *now < *before) {
      events.told.push_back({now->first, now->second, true});
      ++now;
    } else {
      ++before;
      ++now;
    }
  }
}

}  // namespace atl
