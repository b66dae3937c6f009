// What the future of a world depends on, as one hash, and the same by body.

#include <algorithm>

#include "hash.h"
#include "world_impl.h"

namespace atl {
namespace {

// All that shapes the result: the instruction set and a profile do not.
void add_settings(Hash& hash, const Settings& s) {
  for (const int value :
       {s.substeps, s.iterations, s.relax_iterations, static_cast<int>(s.friction), static_cast<int>(s.stabilisation),
        int{s.warm_starting}, int{s.sleeping}, int{s.contact_events}}) {
    hash.add(static_cast<std::uint64_t>(value));
  }
  for (const double value : {s.tolerance, s.correction, s.slop, s.contact_hertz.value_or(0), s.contact_damping_ratio,
                             s.contact_push_speed, s.restitution_threshold, s.sleep_speed, s.time_to_sleep}) {
    hash.add(value);
  }
}

// Nothing where no contact has carried too much, as if there were no remedies.
void add_strain(Hash& hash, const solver::Escalation& escalation, std::uint32_t body) {
  const solver::Escalation::Strain strain = escalation.strain(body);
  if (strain == solver::Escalation::Strain{}) return;
  hash.add(std::uint64_t{body} << 32 | std::uint64_t{strain.sags} << 16 | std::uint64_t{strain.crushed} << 8 |
           std::uint64_t{strain.overloaded});
}

// Worlds that have no joints hash as they would if joints had no settings, unless these are given.
void add_joint_settings(Hash& hash, const Settings& s, bool joints) {
  const Settings left_alone;
  if (!joints && s.joint_solver == left_alone.joint_solver && s.joint_hertz == left_alone.joint_hertz &&
      s.joint_damping_ratio == left_alone.joint_damping_ratio) {
    return;
  }
  hash.add(static_cast<std::uint64_t>(s.joint_solver));
  hash.add(s.joint_hertz.value_or(0));
  hash.add(s.joint_damping_ratio);
}

void add_law(Hash& hash, const solver::Law& law) {
  for (const double value :
       {law.lower, law.upper, law.spring_hertz, law.damping_ratio, law.rest, law.motor_speed, law.motor_force}) {
    hash.add(value);
  }
}

// What the next step reads of a joint, and what later calls can make of it.
void add_joint_state(Hash& hash, const JointTable& table, std::uint32_t index) {
  const solver::Joint& joint = table.joints[index];
  const JointDef& def = table.def[index];
  hash.add(std::uint64_t{joint.first} << 32 | joint.second);
  hash.add(std::uint64_t{def.kind.index()} << 32 | std::uint64_t{joint.rows} << 4 | std::uint64_t{joint.point} << 3 |
           std::uint64_t{def.collide} << 2 | std::uint64_t{table.enabled[index]} << 1 |
           std::uint64_t{table.broken[index]});
  hash.add_all(joint.anchor_first);
  hash.add_all(joint.anchor_second);
  hash.add_all(joint.axes_first.coeffs());
  hash.add_all(joint.axes_second.coeffs());
  hash.add(joint.ratio);
  hash.add(def.break_force);
  hash.add(def.break_torque);
  hash.add_all(joint.point_impulse);
  hash.add_all(joint.tension);
  hash.add_all(joint.force);
  for (std::size_t row = 0; row < joint.rows; ++row) {
    hash.add(std::uint64_t{static_cast<std::uint8_t>(joint.coordinate[row])});
    add_law(hash, joint.law[row]);
    hash.add(joint.impulse[row]);
    hash.add(joint.position[row]);
    hash.add(std::uint64_t{static_cast<std::uint8_t>(joint.limit[row])} << 8 |
             static_cast<std::uint8_t>(table.limit_before[index][row]));
  }
}

void add_surface(Hash& hash, const solver::Surface& surface) {
  if (surface.is_plain()) return;
  hash.add_all(surface.velocity);
  hash.add(surface.rolling_friction);
  hash.add(surface.torsional_friction);
}

// Of bodies that may meet all others there is nothing to tell.
void add_filter(Hash& hash, const collision::Filter& filter) {
  const collision::Filter meets_all;
  if (filter.category == meets_all.category && filter.mask == meets_all.mask && filter.group == meets_all.group) return;
  hash.add(std::uint64_t{filter.category} << 32 | filter.mask);
  hash.add(static_cast<std::uint32_t>(filter.group));
}

void add_box(Hash& hash, const collision::Aabb& box) {
  hash.add_all(box.lower);
  hash.add_all(box.upper);
}

// What the next step reads of a contact: how its manifold was captured, and the impulses.
void add_contact(Hash& hash, const collision::Contact& contact, const collision::ContactManifold& manifold) {
  hash.add(contact.pair.key());
  hash.add(std::uint64_t{contact.axis} << 32 | std::uint64_t{contact.count} << 16 | std::uint64_t{contact.part} << 8 |
           std::uint64_t{contact.reference_is_second});
  hash.add(contact.margin);
  hash.add(contact.gap);
  if (contact.gap > 0) {
    hash.add(contact.lever);
    hash.add_all(contact.apart_from);
    hash.add(contact.turned);
  }
  hash.add(contact.tolerance);
  for (std::size_t i = 0; i < contact.count; ++i) {
    hash.add(contact.ids[i]);
    hash.add_all(contact.points[i]);
    hash.add(manifold.normal_impulse[i]);
  }
  hash.add_all(contact.normal);
  hash.add_all(contact.orientation);
  for (std::size_t i = 0; i < 3; ++i) {
    hash.add(contact.centre_incident[i]);
    hash.add(contact.centre_reference[i]);
    hash.add(manifold.friction_impulse[i]);
  }
  hash.add(manifold.twist_impulse);
}

// A contact that rests counts as it is when it wakes, and is not found from where its bodies are.
void add_resting_points(Hash& hash, const collision::Contact& contact, const collision::ContactManifold& manifold) {
  if (contact.count == 0) return;
  for (std::size_t i = 0; i < 3; ++i) {
    hash.add(manifold.normal[i]);
    hash.add(manifold.anchor_first[i]);
    hash.add(manifold.anchor_second[i]);
  }
  hash.add(manifold.lever);
  for (std::size_t i = 0; i < contact.count; ++i) {
    hash.add(manifold.x[i]);
    hash.add(manifold.y[i]);
    hash.add(manifold.separation[i]);
  }
}

}  // namespace

// Where each part of a body's state goes: all to one hash, or each to its own.
struct World::Impl::BodyParts {
  Hash& pose;
  Hash& velocity;
  Hash& input;
  Hash& rest;
  Hash& bounds;
  Hash& contacts;
};

// A hash for each part of a body's state.
struct World::Impl::BodyHasher {
  Hash pose, velocity, input, rest, bounds, contacts, joints;

  BodyParts parts() { return {pose, velocity, input, rest, bounds, contacts}; }
  BodyHash value() const {
    return {pose.value(),   velocity.value(), input.value(), rest.value(),
            bounds.value(), contacts.value(), joints.value()};
  }
};

// All but its contacts and joints.
void World::Impl::add_body_state(const BodyParts& hash, std::uint32_t body) const {
  const bool alive = records.alive[body] != 0;
  hash.pose.add_all(bodies.position(body));
  hash.pose.add_all(bodies.orientation(body).coeffs());
  hash.velocity.add_all(bodies.velocity(body));
  hash.velocity.add_all(bodies.angular_velocity(body));

  hash.input.add(std::uint64_t{records.generation[body]} << 1 | std::uint64_t{alive});
  hash.input.add_all(bodies.force(body));
  hash.input.add_all(bodies.torque(body));
  if (alive && !bodies.surfaces.empty()) add_surface(hash.input, bodies.surfaces[body]);
  if (const auto ignored = records.ignored.find(body); ignored != records.ignored.end()) {
    std::vector<std::uint32_t> others = ignored->second;
    std::sort(others.begin(), others.end());
    hash.input.add_all(others);
  }

  hash.rest.add(sleeping.awake[body]);
  hash.rest.add(sleeping.rest_time[body]);
  hash.rest.add(sleeping.ring[body]);

  hash.bounds.add(bodies.turned[body]);
  hash.bounds.add(bodies.slack[body]);
  hash.bounds.add(bodies.outgrown[body]);
  hash.bounds.add(stretch_[body]);
  if (alive) {
    const bool quarantined = quarantine.contains(body);
    for_each_collider(body, [&](std::uint32_t collider) {
      hash.bounds.add(collider);
      if (!broadphase.is_half_space(collider)) add_box(hash.bounds, broadphase.fat_box(collider));
      add_filter(hash.input, quarantined ? quarantine.kept(body).filter : broadphase.filter(collider));
    });
  }
  add_strain(hash.contacts, escalation_, body);
}

void World::Impl::add_contact_state(Hash& hash, std::uint32_t slot) const {
  Hash local = hash;  // stays in a register: contacts are most of the state
  const collision::Contact& contact = cache.contacts[slot];
  add_contact(local, contact, cache.manifolds[slot]);
  if (!may_move(contact.body_first) && !may_move(contact.body_second)) {
    add_resting_points(local, contact, cache.manifolds[slot]);
  }
  if (slot < surface_contacts_.size()) local.add_all(surface_contacts_[slot].rolling_impulse);
  hash = local;
}

std::uint64_t World::Impl::state_hash() const {
  Hash hash;
  add_settings(hash, settings);
  if (settings.contact_solver != Settings{}.contact_solver) {
    hash.add(static_cast<std::uint64_t>(settings.contact_solver));
  }
  add_joint_settings(hash, settings, joints.size() > 0);
  for (int i = 0; i < 3; ++i) hash.add(gravity[i]);
  hash.add(last_dt_);
  hash.add_all(records.free);
  hash.add_all(colliders.free);
  const BodyParts parts = {hash, hash, hash, hash, hash, hash};
  hash.add(static_cast<std::uint64_t>(bodies.size()));
  for (std::uint32_t body = 0; body < bodies.size(); ++body) add_body_state(parts, body);
  if (settings.contact_events) hash.add(std::uint64_t{events_noted_});
  for (const auto& [a, b] : touched_) {
    hash.add(std::uint64_t{a.index} << 32 | b.index);
    hash.add(std::uint64_t{a.generation} << 32 | b.generation);
  }
  for (const Quarantined& out : quarantine.bodies()) {
    hash.add(std::uint64_t{out.id.index} << 32 | static_cast<std::uint64_t>(out.reason));
    hash.add(static_cast<std::uint64_t>(out.step));
  }
  hash.add_all(escalation_.arrived());
  if (joints.size() > 0) {
    hash.add_all(joints.alive);
    hash.add_all(joints.generation);
    hash.add_all(joints.free);
    for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
      if (joints.alive[joint]) add_joint_state(hash, joints, joint);
    }
  }
  hash.add(static_cast<std::uint64_t>(cache.size()));
  for (const std::uint32_t slot : cache.all_in_order()) add_contact_state(hash, slot);
  return hash.value();
}

std::vector<BodyHash> World::Impl::body_hashes() const {
  std::vector<BodyHasher> hashers(bodies.size());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) add_body_state(hashers[body].parts(), body);
  for (const std::uint32_t slot : cache.all_in_order()) {
    const collision::Contact& contact = cache.contacts[slot];
    for (const std::uint32_t body : {contact.body_first, contact.body_second}) {
      if (records.dynamic[body]) add_contact_state(hashers[body].contacts, slot);
    }
  }
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    if (!joints.alive[joint]) continue;
    for (const std::uint32_t body : {joints.joints[joint].first, joints.joints[joint].second}) {
      if (records.dynamic[body]) add_joint_state(hashers[body].joints, joints, joint);
    }
  }
  std::vector<BodyHash> hashes(bodies.size());
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    if (records.alive[body]) hashes[body] = hashers[body].value();
  }
  return hashes;
}

BodyHash World::Impl::body_hash(std::uint32_t body) const {
  BodyHasher hasher;
  add_body_state(hasher.parts(), body);
  if (!records.dynamic[body]) return hasher.value();

  std::vector<std::uint32_t> own;
  cache.for_each_contact_of(body, [&](std::uint32_t slot) { own.push_back(slot); });
  const auto place = [this](std::uint32_t slot) {
    return std::pair(cache.contacts[slot].pair.key(), cache.contacts[slot].part);
  };
  std::sort(own.begin(), own.end(), [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
  for (const std::uint32_t slot : own) add_contact_state(hasher.contacts, slot);

  own.clear();
  joints.for_each_of(body, [&](std::uint32_t joint) { own.push_back(joint); });
  std::sort(own.begin(), own.end());
  for (const std::uint32_t joint : own) add_joint_state(hasher.joints, joints, joint);
  return hasher.value();
}

}  // namespace atl
