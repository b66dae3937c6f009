// The state of each body by itself, as hashes: what WorldState tells of the world, sorted by whose it is.

#include <atoll/body_hash.h>

#include <algorithm>

#include "state/state_archive.h"
#include "state/world_state.h"
#include "world/world_impl.h"

namespace atl {

struct World::Impl::BodyParts {
  StateHash pose, velocity, input, rest, bounds, contacts, joints;

  BodyHash value() const {
    return {.pose = pose.result(),
            .velocity = velocity.result(),
            .input = input.result(),
            .rest = rest.result(),
            .bounds = bounds.result(),
            .contacts = contacts.result(),
            .joints = joints.result()};
  }
};

// All but its contacts and joints.
void World::Impl::hash_body(BodyParts& parts, std::uint32_t body) const {
  const bool alive = records.alive[body] != 0;
  parts.pose.values(bodies.position(body).data(), 3);
  parts.pose.values(bodies.orientation(body).coeffs().data(), 4);
  parts.velocity.values(bodies.velocity(body).data(), 3);
  parts.velocity.values(bodies.angular_velocity(body).data(), 3);

  parts.input.value(records.generation[body]);
  parts.input.value(alive);
  parts.input.values(bodies.force(body).data(), 3);
  parts.input.values(bodies.torque(body).data(), 3);
  if (alive && !bodies.surfaces.empty()) {
    const solver::Surface& surface = bodies.surfaces[body];
    parts.input.values(surface.velocity.data(), 3);
    parts.input.value(surface.rolling_friction);
    parts.input.value(surface.torsional_friction);
  }
  if (const auto ignored = records.ignored.find(body); ignored != records.ignored.end()) {
    std::vector<std::uint32_t> others = ignored->second;
    std::sort(others.begin(), others.end());
    parts.input.list(others);
  }

  parts.rest.value(sleeping.awake[body]);
  parts.rest.value(sleeping.rest_time[body]);
  parts.rest.value(sleeping.ring[body]);

  parts.bounds.value(bodies.turned[body]);
  parts.bounds.value(aabbs.bounds.aabb_margin[body]);
  parts.bounds.value(aabbs.bounds.aabb_dirty[body]);
  parts.bounds.value(aabbs.swept_margins()[body]);
  if (alive) {
    const bool quarantined = quarantine.contains(body);
    colliders.for_each_of(body, [&](std::uint32_t collider) {
      parts.bounds.value(collider);
      if (!quarantined && !broadphase.is_half_space(collider)) {
        const collision::Aabb box = broadphase.fat_box(collider);
        parts.bounds.values(box.lower.data(), 3);
        parts.bounds.values(box.upper.data(), 3);
      }
      visit_filter(parts.input, quarantined ? quarantine.kept(body).filter : broadphase.filter(collider));
    });
  }
  const solver::SolverSelection::Strain strain = selection_.strain(body);
  visit_strain(parts.contacts, strain);
}

void World::Impl::hash_contact(StateHash& hash, std::uint32_t slot) const {
  StateHash local = hash;  // stays in a register
  const collision::Contact& contact = cache.contacts[slot];
  local.value(contact.pair.key());
  local.value(contact.part);
  WorldState(local, *this).visit_one_contact(slot);
  hash = local;
}

std::vector<BodyHash> World::Impl::body_hashes() const {
  std::vector<BodyParts> parts(bodies.size());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) hash_body(parts[body], body);
  for (const std::uint32_t slot : cache.all_in_order()) {
    const collision::Contact& contact = cache.contacts[slot];
    for (const std::uint32_t body : {contact.body_first, contact.body_second}) {
      if (records.dynamic[body]) hash_contact(parts[body].contacts, slot);
    }
  }
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    if (!joints.alive[joint]) continue;
    for (const std::uint32_t body : {joints.joints[joint].first, joints.joints[joint].second}) {
      if (records.dynamic[body]) WorldState(parts[body].joints, *this).visit_one_joint(joint);
    }
  }
  std::vector<BodyHash> hashes(bodies.size());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    if (records.alive[body]) hashes[body] = parts[body].value();
  }
  return hashes;
}

BodyHash World::Impl::body_hash(std::uint32_t body) const {
  BodyParts parts;
  hash_body(parts, body);
  if (!records.dynamic[body]) return parts.value();

  std::vector<std::uint32_t> own;
  cache.for_each_contact_of(body, [&](std::uint32_t slot) { own.push_back(slot); });
  const auto place = [this](std::uint32_t slot) {
    return std::pair(cache.contacts[slot].pair.key(), cache.contacts[slot].part);
  };
  std::sort(own.begin(), own.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  for (const std::uint32_t slot : own) hash_contact(parts.contacts, slot);

  own.clear();
  joints.for_each_of(body, [&](std::uint32_t joint) { own.push_back(joint); });
  std::sort(own.begin(), own.end());
  for (const std::uint32_t joint : own) WorldState(parts.joints, *this).visit_one_joint(joint);
  return parts.value();
}

}  // namespace atl
