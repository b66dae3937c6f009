#include <solver/constraints/motion_locks.h>

#include "world/world_impl.h"

namespace atl {

// Made when asked for: a step that nobody asks pays nothing.
std::span<const ContactForce> World::Impl::contact_forces() {
  if (contact_forces_valid_) return contact_forces_;
  contact_forces_.clear();
  contact_forces_valid_ = true;
  if (last_substep_ == 0) return contact_forces_;
  place_idle_contacts();
  const double per_impulse = 1 / last_substep_;
  for (const std::uint32_t slot : cache.all_in_order()) {
    const collision::Contact& contact = cache.contacts[slot];
    const collision::ContactManifold& manifold = cache.manifolds[slot];
    if (contact.count == 0) continue;
    const auto vector = [](const float(&v)[3]) { return Vector3(v[0], v[1], v[2]); };
    const auto id = [this](std::uint32_t body) { return BodyId{body, records.generation[body]}; };
    const collision::Tangents frame = collision::tangents(manifold.normal);
    const Vector3 t1(frame.first[0], frame.first[1], frame.first[2]);
    const Vector3 t2(frame.second[0], frame.second[1], frame.second[2]);
    // Where the contact was as the step started: the bodies have moved since, by far less than their size.
    const Vector3 centre = bodies.position(contact.body_first) + vector(manifold.anchor_first);
    // What stays in a plane is pushed within it.
    Vector3 normal = vector(manifold.normal);
    if (const int plane = solver::shared_plane(bodies, contact.body_first, contact.body_second); plane >= 0) {
      normal[plane] = 0;
      normal.normalize();
    }
    double total = 0;
    for (const float impulse : manifold.normal_impulse) total += static_cast<double>(impulse);
    for (std::size_t i = 0; i < contact.count; ++i) {
      const double impulse = manifold.normal_impulse[i];
      if (!(impulse > 0)) continue;
      contact_forces_.push_back({id(contact.body_first), id(contact.body_second),
                                 centre + manifold.x[i] * t1 + manifold.y[i] * t2, normal, impulse * per_impulse,
                                 vector(manifold.friction_impulse) * (per_impulse * impulse / total),
                                 manifold.separation[i], contact.ids[i]});
    }
  }
  return contact_forces_;
}

// Steps leave alone what rests on both sides, so where its points are is found out from the poses by whoever asks.
void World::Impl::place_idle_contacts() {
  if (cache.order.size() == cache.size()) return;
  reaches_.resize(bodies.size());
  std::vector<std::uint32_t> idle;
  for (const std::uint32_t slot : cache.all_in_order()) {
    const collision::Contact& contact = cache.contacts[slot];
    const bool rests = !active_.contains(contact.body_first) && !active_.contains(contact.body_second);
    if (rests && contact.count > 0) idle.push_back(slot);
  }
  collision::place_contacts(cache, broadphase, contact_input(), idle, arena);
}

}  // namespace atl
