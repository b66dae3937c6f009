// The state of each body by itself, as hashes: what WorldState tells of the world, sorted by whose it is.

#include "state/body_hashes.h"

#include <algorithm>

#include "state/state_archive.h"
#include "state/world_state.h"
#include "world/colliders.h"
#include "world/stores.h"

namespace atl {

namespace {

struct BodyParts {
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
void hash_body(const Stores& world, BodyParts& parts, std::uint32_t body) {
  const bool alive = world.records.alive[body] != 0;
  parts.pose.values(world.bodies.position(body).data(), 3);
  parts.pose.values(world.bodies.orientation(body).coeffs().data(), 4);
  parts.velocity.values(world.bodies.velocity(body).data(), 3);
  parts.velocity.values(world.bodies.angular_velocity(body).data(), 3);

  visit_all(parts.input, world.records.generation[body], alive);
  parts.input.values(world.bodies.force(body).data(), 3);
  parts.input.values(world.bodies.torque(body).data(), 3);
  // Plain ones count for nothing, whether the world has an entry of them or not.
  if (alive && !world.bodies.surfaces.empty() && !world.bodies.surfaces[body].is_plain()) {
    const solver::Surface& surface = world.bodies.surfaces[body];
    parts.input.values(surface.motion.velocity.data(), 3);
    if (!surface.motion.angular_velocity.isZero(0)) parts.input.values(surface.motion.angular_velocity.data(), 3);
    visit_all(parts.input, surface.rolling_friction, surface.torsional_friction);
  }
  if (const auto disabled = world.records.disabled_pairs.find(body); disabled != world.records.disabled_pairs.end()) {
    parts.input.list(disabled->second);
  }

  if (!world.choices.is_empty()) {
    for (const collision::Pair pair : world.choices.refused) {
      const bool is_own = world.colliders.body[pair.first] == body || world.colliders.body[pair.second] == body;
      if (is_own) parts.input.value(pair.key());
    }
    const std::vector<std::uint32_t>& again = world.choices.refiltered;
    if (std::binary_search(again.begin(), again.end(), body)) parts.input.value(true);
  }

  visit_all(parts.rest, world.sleeping.awake[body], world.sleeping.rest_time[body], world.sleeping.ring[body]);
  visit_all(parts.bounds, world.bodies.turned[body], world.aabbs.bounds.aabb_margin[body],
            world.aabbs.bounds.aabb_dirty[body], world.aabbs.swept_margins()[body]);
  if (alive) {
    const bool quarantined = world.quarantine.contains(body);
    world.colliders.for_each_of(body, [&](std::uint32_t collider) {
      parts.bounds.value(collider);
      if (!quarantined && !world.broadphase.proxies().is_half_space(collider)) {
        const collision::Aabb box = world.broadphase.proxies().fat_box(collider);
        visit_all(parts.bounds, box.lower, box.upper);
      }
      const collision::Filter filter = filter_of(world, collider);
      visit_filter(parts.input, filter);
    });
  }
  solver::SolverSelection::Finding finding = world.selection.finding(body);
  visit_finding(parts.contacts, finding);
  if (world.settings.target.is_set()) {
    solver::SubstepControl::History substeps = world.control.history(body);
    visit_history(parts.contacts, substeps);
  }
}

void hash_contact(const Stores& world, StateHash& hash, std::uint32_t slot) {
  StateHash local = hash;  // stays in a register
  const collision::Contact& contact = world.cache.contacts[slot];
  local.value(contact.pair.key());
  local.value(contact.part);
  WorldState(local, world).visit_one_contact(slot);
  hash = local;
}

}  // namespace

std::vector<BodyHash> body_hashes(const Stores& world) {
  std::vector<BodyParts> parts(world.bodies.size());
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) hash_body(world, parts[body], body);
  for (const std::uint32_t slot : world.cache.all_in_order()) {
    const collision::Contact& contact = world.cache.contacts[slot];
    for (const std::uint32_t body : {contact.body_first, contact.body_second}) {
      if (world.records.dynamic[body]) hash_contact(world, parts[body].contacts, slot);
    }
  }
  for (std::uint32_t joint = 0; joint < world.joints.size(); ++joint) {
    // A tendon is of no body: what it does shows in those that it pulls on.
    if (!world.joints.alive[joint] || world.joints.joints[joint].is_tendon()) continue;
    for (const std::uint32_t body : {world.joints.joints[joint].first, world.joints.joints[joint].second}) {
      if (world.records.dynamic[body]) WorldState(parts[body].joints, world).visit_one_joint(joint);
    }
  }
  std::vector<BodyHash> hashes(world.bodies.size());
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) {
    if (world.records.alive[body]) hashes[body] = parts[body].value();
  }
  return hashes;
}

BodyHash body_hash(const Stores& world, std::uint32_t body) {
  BodyParts parts;
  hash_body(world, parts, body);
  if (!world.records.dynamic[body]) return parts.value();

  std::vector<std::uint32_t> own;
  world.cache.for_each_contact_of(body, [&](std::uint32_t slot) { own.push_back(slot); });
  const auto place = [&](std::uint32_t slot) {
    return std::pair(world.cache.contacts[slot].pair.key(), world.cache.contacts[slot].part);
  };
  std::sort(own.begin(), own.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  for (const std::uint32_t slot : own) hash_contact(world, parts.contacts, slot);

  own.clear();
  world.joints.for_each_of(body, [&](std::uint32_t joint) { own.push_back(joint); });
  std::sort(own.begin(), own.end());
  for (const std::uint32_t joint : own) WorldState(parts.joints, world).visit_one_joint(joint);
  return parts.value();
}

}  // namespace atl
