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

// Bodies may have several contacts with each other, so what counts is the list of bodies that touch.
void World::Impl::note_events() {
  const auto id = [this](std::uint32_t body) { return BodyId{body, records.generation[body]}; };
  std::swap(touched_, touched_before_);
  touched_.clear();
  for (const std::uint32_t slot : cache.order) {
    const collision::Contact& contact = cache.contacts[slot];
    if (!touches(contact, cache.manifolds[slot])) continue;
    const auto [a, b] = std::minmax(contact.body_first, contact.body_second);
    touched_.emplace_back(id(a), id(b));
  }
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());

  contact_events_.clear();
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
