#include <bit>

#include "world_impl.h"

namespace atl {
namespace {

// 64-bit hash over words: multiply and fold, as in wyhash (Wang Yi, public domain), whose mixing step this is.
class Hash {
 public:
  void add(std::uint64_t word) {
    const __uint128_t product = static_cast<__uint128_t>(state_ ^ word) * 0xa0761d6478bd642fu;
    state_ = (static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64)) + 0xe7037ed1a0b428dbu;
  }
  void add(double value) { add(std::bit_cast<std::uint64_t>(value)); }
  void add(float value) { add(std::uint64_t{std::bit_cast<std::uint32_t>(value)}); }
  void add(std::uint32_t value) { add(std::uint64_t{value}); }
  void add(std::uint8_t value) { add(std::uint64_t{value}); }

  template <typename Range>
  void add_all(const Range& range) {
    add(static_cast<std::uint64_t>(std::size(range)));
    for (const auto& value : range) add(value);
  }

  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15u;
};

void add_box(Hash& hash, const collision::Aabb& box) {
  hash.add_all(box.lower);
  hash.add_all(box.upper);
}

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
void add_escalation(Hash& hash, const Settings& s, const solver::Escalation& escalation) {
  if (s.contact_solver != Settings{}.contact_solver) hash.add(static_cast<std::uint64_t>(s.contact_solver));
  for (const std::uint32_t body : escalation.arrived()) hash.add(body);
  for (const std::uint32_t body : escalation.strained()) {
    const solver::Escalation::Strain strain = escalation.strain(body);
    hash.add(std::uint64_t{body} << 32 | std::uint64_t{strain.sags} << 16 | std::uint64_t{strain.crushed} << 8 |
             std::uint64_t{strain.overloaded});
  }
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

void add_surface(Hash& hash, std::size_t body, const solver::Surface& surface) {
  if (surface.is_plain()) return;
  hash.add(static_cast<std::uint64_t>(body));
  hash.add_all(surface.velocity);
  hash.add(surface.rolling_friction);
  hash.add(surface.torsional_friction);
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

}  // namespace

std::uint64_t World::Impl::state_hash() const {
  Hash hash;
  add_settings(hash, settings);
  for (int i = 0; i < 3; ++i) hash.add(gravity[i]);
  hash.add_all(records.alive);
  hash.add_all(records.generation);
  hash.add_all(records.free);
  hash.add_all(bodies.positions);
  hash.add_all(bodies.orientations);
  hash.add_all(bodies.velocities);
  hash.add_all(bodies.angular_velocities);
  hash.add_all(bodies.forces);
  hash.add_all(bodies.torques);
  for (std::size_t body = 0; body < bodies.surfaces.size(); ++body) {
    if (records.alive[body]) add_surface(hash, body, bodies.surfaces[body]);
  }
  hash.add_all(sleeping.awake);
  hash.add_all(sleeping.rest_time);
  hash.add_all(sleeping.ring);
  hash.add_all(bodies.turned);
  hash.add_all(bodies.slack);
  hash.add_all(bodies.outgrown);
  hash.add_all(stretch_);
  hash.add(last_dt_);
  hash.add_all(colliders.free);
  for (std::uint32_t collider = 0; collider < colliders.size(); ++collider) {
    hash.add(colliders.body[collider]);
    if (colliders.body[collider] == collision::ColliderTable::none) continue;
    if (!broadphase.is_half_space(collider)) add_box(hash, broadphase.fat_box(collider));
  }
  for (const auto& [a, b] : touched_) {
    hash.add(std::uint64_t{a.index} << 32 | b.index);
    hash.add(std::uint64_t{a.generation} << 32 | b.generation);
  }
  for (const Quarantined& out : quarantine.bodies()) {
    hash.add(std::uint64_t{out.id.index} << 32 | static_cast<std::uint64_t>(out.reason));
    hash.add(static_cast<std::uint64_t>(out.step));
  }
  add_escalation(hash, settings, escalation_);
  add_joint_settings(hash, settings, joints.size() > 0);
  if (joints.size() > 0) {
    hash.add_all(joints.alive);
    hash.add_all(joints.generation);
    hash.add_all(joints.free);
    for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
      if (joints.alive[joint]) add_joint_state(hash, joints, joint);
    }
  }
  hash.add(static_cast<std::uint64_t>(cache.size()));
  for (const std::uint32_t slot : cache.all_in_order()) {
    add_contact(hash, cache.contacts[slot], cache.manifolds[slot]);
    if (slot < surface_contacts_.size()) hash.add_all(surface_contacts_[slot].rolling_impulse);
  }
  return hash.value();
}

}  // namespace atl
