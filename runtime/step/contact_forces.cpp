#include <solver/constraints/motion_locks.h>

#include "step/results.h"
#include "world/bodies.h"

namespace atl {

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
    const auto vector = [](const float(&v)[3]) { return Vector3(v[0], v[1], v[2]); };
    const auto id = [&](std::uint32_t body) { return id_of(world, body); };
    const collision::Tangents frame = collision::tangents(manifold.normal);
    const Vector3 t1(frame.first[0], frame.first[1], frame.first[2]);
    const Vector3 t2(frame.second[0], frame.second[1], frame.second[2]);
    // Where the contact was as the step started: the bodies have moved since, by far less than their size.
    const Vector3 centre = world.bodies.position(contact.body_first) + vector(manifold.anchor_first);
    // What stays in a plane is pushed within it.
    Vector3 normal = vector(manifold.normal);
    if (const int plane = solver::shared_plane(world.bodies, contact.body_first, contact.body_second); plane >= 0) {
      normal[plane] = 0;
      normal.normalize();
    }
    double total = 0;
    for (const float impulse : manifold.normal_impulse) total += static_cast<double>(impulse);
    for (std::size_t i = 0; i < contact.count; ++i) {
      const double impulse = manifold.normal_impulse[i];
      if (!(impulse > 0)) continue;
      world.results.contact_forces.push_back(
          {id(contact.body_first), id(contact.body_second), centre + manifold.x[i] * t1 + manifold.y[i] * t2, normal,
           impulse * per_impulse, vector(manifold.friction_impulse) * (per_impulse * impulse / total),
           manifold.separation[i], contact.ids[i]});
    }
  }
  return world.results.contact_forces;
}

}  // namespace atl
