#include <solver/integrate/motion_locks.h>

#include "step/results.h"
#include "world/bodies.h"

namespace atl {

namespace {

Vector3 vector3(const auto& v) { return {v[0], v[1], v[2]}; }

}  // namespace

Vector3 ManifoldPlace::point(const collision::ContactManifold& manifold, std::size_t i) const {
  return centre + manifold.x[i] * tangents[0] + manifold.y[i] * tangents[1];
}

ManifoldPlace place_of(const Stores& world, const collision::Contact& contact,
                       const collision::ContactManifold& manifold) {
  const collision::Tangents frame = collision::tangents(manifold.normal);
  // Where the contact was as the step started: the bodies have moved since, by far less than their size.
  ManifoldPlace place{.centre = world.bodies.position(contact.body_first) + vector3(manifold.anchor_first),
                      .tangents = {vector3(frame.first), vector3(frame.second)},
                      .normal = vector3(manifold.normal)};
  // What stays in a plane is pushed within it.
  if (const int plane = solver::shared_plane(world.bodies, contact.body_first, contact.body_second); plane >= 0) {
    place.normal[plane] = 0;
    place.normal.normalize();
  }
  return place;
}

std::span<const ContactForce> contact_forces(Stores& world, const collision::NarrowphaseKernels& kernels,
                                             jobs::Arena& arena) {
  if (world.results.contact_forces_valid) return world.results.contact_forces;
  world.results.contact_forces.clear();
  world.results.contact_forces_valid = true;
  if (world.clock.last_substep == 0) return world.results.contact_forces;
  place_idle_contacts(world, kernels, arena);
  const double per_impulse = 1 / world.clock.last_substep;
  for (const std::uint32_t slot : world.cache.all_in_order()) {
    const collision::Contact& contact = world.cache.contacts[slot];
    const collision::ContactManifold& manifold = world.cache.manifolds[slot];
    if (contact.count == 0) continue;
    const auto id = [&](std::uint32_t body) { return id_of(world, body); };
    const ManifoldPlace place = place_of(world, contact, manifold);
    double total = 0;
    for (const float impulse : manifold.normal_impulse) total += static_cast<double>(impulse);
    for (std::size_t i = 0; i < contact.count; ++i) {
      const double impulse = manifold.normal_impulse[i];
      if (!(impulse > 0)) continue;
      world.results.contact_forces.push_back({id(contact.body_first), id(contact.body_second), place.point(manifold, i),
                                              place.normal, impulse * per_impulse,
                                              vector3(manifold.friction_impulse) * (per_impulse * impulse / total),
                                              manifold.separation[i], contact.ids[i]});
    }
  }
  return world.results.contact_forces;
}

}  // namespace atl
