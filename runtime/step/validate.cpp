#include "step/validate.h"

#include <jobs/assert.h>

#include <cmath>

namespace atl {
namespace {

constexpr std::uint32_t none = ~std::uint32_t{0};

// Unit vectors and quaternions are normalised at every step: what is left is rounding, of floats in manifolds.
constexpr double double_rounding = 1e-9;
constexpr double float_rounding = 1e-5;

void validate_mass(const solver::BodyTable& bodies, std::uint32_t body) {
  const double inverse_mass = bodies.inverse_mass[body];
  const Matrix3& inertia = bodies.inertia[body];
  const Matrix3& inverse = bodies.inverse_inertia[body];
  if (bodies.mobility[body] != solver::Mobility::Dynamic) {
    ATL_ASSERT(inverse_mass == 0, body, inverse_mass);
    ATL_ASSERT(inverse.isZero(0), body, inverse.norm());
    return;
  }
  ATL_ASSERT(inverse_mass >= 0 && std::isfinite(inverse_mass), body, inverse_mass);
  for (int i = 0; i < 3; ++i) {
    ATL_ASSERT(inertia(i, i) > 0 && std::isfinite(inertia(i, i)), body, i, inertia(i, i));
    ATL_ASSERT(inverse(i, i) >= 0 && std::isfinite(inverse(i, i)), body, i, inverse(i, i));
    const int j = (i + 1) % 3;
    ATL_ASSERT(std::abs(inertia(i, j) - inertia(j, i)) <= double_rounding * inertia.norm(), body, inertia(i, j),
               inertia(j, i));
    ATL_ASSERT(std::abs(inverse(i, j) - inverse(j, i)) <= double_rounding * inverse.norm(), body, inverse(i, j),
               inverse(j, i));
  }
}

void validate_motion(const Stores& world, std::uint32_t body) {
  const solver::BodyTable& bodies = world.bodies;
  const double turn = bodies.orientation(body).norm();
  ATL_ASSERT(std::abs(turn - 1) < double_rounding, body, turn);
  ATL_ASSERT(bodies.position(body).allFinite(), body, bodies.position(body).x(), bodies.position(body).y(),
             bodies.position(body).z());
  ATL_ASSERT(bodies.velocity(body).allFinite(), body, bodies.velocity(body).norm());
  ATL_ASSERT(bodies.angular_velocity(body).allFinite(), body, bodies.angular_velocity(body).norm());
  ATL_ASSERT(bodies.turned[body] >= 0, body, bodies.turned[body]);
  ATL_ASSERT(bodies.radius[body] >= 0, body, bodies.radius[body]);
  ATL_ASSERT(bodies.linear_damping[body] >= 0 && bodies.angular_damping[body] >= 0, body, bodies.linear_damping[body],
             bodies.angular_damping[body]);
}

void validate_bodies(const Stores& world) {
  const BodyRecords& records = world.records;
  const std::size_t count = world.bodies.size();
  ATL_ASSERT(records.alive.size() == count, records.alive.size(), count);
  ATL_ASSERT(records.generation.size() == count, records.generation.size(), count);
  ATL_ASSERT(records.type.size() == count, records.type.size(), count);
  ATL_ASSERT(records.dynamic.size() == count, records.dynamic.size(), count);
  ATL_ASSERT(records.continuous.size() == count, records.continuous.size(), count);
  ATL_ASSERT(records.sensor.size() == count, records.sensor.size(), count);
  ATL_ASSERT(records.user_data.size() == count, records.user_data.size(), count);
  ATL_ASSERT(records.constants.size() == count, records.constants.size(), count);
  ATL_ASSERT(world.sleeping.awake.size() == count, world.sleeping.awake.size(), count);
  std::size_t alive = 0;
  for (std::uint32_t body = 0; body < count; ++body) {
    if (!records.alive[body]) continue;
    ++alive;
    ATL_ASSERT(records.constants[body] != nullptr, body);
    ATL_ASSERT(!records.dynamic[body] || records.type[body] == BodyType::Dynamic, body,
               static_cast<int>(records.type[body]));
    if (world.quarantine.contains(body)) continue;  // it may have any state, and counts as fixed
    validate_mass(world.bodies, body);
    validate_motion(world, body);
  }
  ATL_ASSERT(alive == records.count, alive, records.count);
  ATL_ASSERT(alive + records.free.size() == count, alive, records.free.size(), count);
  for (const std::uint32_t body : records.free) {
    ATL_ASSERT(body < count && !records.alive[body], body, count);
  }
}

// Sleeping islands are rings, so every body of one has exactly one before it.
void validate_sleeping(const Stores& world) {
  const Sleeping& sleeping = world.sleeping;
  ATL_ASSERT(sleeping.rest_time.size() == world.bodies.size(), sleeping.rest_time.size(), world.bodies.size());
  ATL_ASSERT(sleeping.ring.size() == world.bodies.size(), sleeping.ring.size(), world.bodies.size());
  ATL_ASSERT(sleeping.reported_asleep.size() == world.bodies.size(), sleeping.reported_asleep.size(),
             world.bodies.size());
  std::vector<std::uint8_t> has_one_before(sleeping.ring.size(), 0);
  std::int64_t asleep = 0;
  for (std::uint32_t body = 0; body < sleeping.ring.size(); ++body) {
    const std::uint32_t next = sleeping.ring[body];
    ATL_ASSERT(sleeping.rest_time[body] >= 0, body, sleeping.rest_time[body]);
    if (next == none) continue;
    ++asleep;
    ATL_ASSERT(next < sleeping.ring.size(), body, next);
    ATL_ASSERT(!has_one_before[next], body, next);
    ATL_ASSERT(!sleeping.awake[body], body);
    ATL_ASSERT(world.records.dynamic[body], body);
    ATL_ASSERT(world.bodies.velocity(body).isZero(0) && world.bodies.angular_velocity(body).isZero(0), body,
               world.bodies.velocity(body).norm(), world.bodies.angular_velocity(body).norm());
    has_one_before[next] = 1;
  }
  ATL_ASSERT(asleep == sleeping.asleep, asleep, sleeping.asleep);
}

void validate_colliders(const Stores& world) {
  const collision::ColliderTable& colliders = world.colliders;
  ATL_ASSERT(colliders.child.size() == colliders.size(), colliders.child.size(), colliders.size());
  ATL_ASSERT(colliders.next.size() == colliders.size(), colliders.next.size(), colliders.size());
  ATL_ASSERT(colliders.has_local_offset.size() == colliders.size(), colliders.has_local_offset.size(),
             colliders.size());
  ATL_ASSERT(colliders.first.size() == world.bodies.size(), colliders.first.size(), world.bodies.size());
  for (const std::uint32_t collider : colliders.free) {
    ATL_ASSERT(collider < colliders.size() && colliders.body[collider] == none, collider, colliders.size());
  }
  std::size_t in_use = 0;
  for (std::uint32_t collider = 0; collider < colliders.size(); ++collider) {
    const std::uint32_t body = colliders.body[collider];
    if (body == none) continue;
    ++in_use;
    ATL_ASSERT(body < world.bodies.size() && world.records.alive[body], collider, body);
    const std::uint32_t next = colliders.next[collider];
    ATL_ASSERT(next == none || colliders.body[next] == body, collider, next, body);
  }
  ATL_ASSERT(in_use + colliders.free.size() == colliders.size(), in_use, colliders.free.size(), colliders.size());
}

void validate_manifold(const collision::Contact& contact, const collision::ContactManifold& manifold,
                       std::uint32_t slot) {
  ATL_ASSERT(contact.count <= collision::max_points, slot, contact.count);
  ATL_ASSERT(manifold.friction >= 0 && manifold.restitution >= 0, slot, manifold.friction, manifold.restitution);
  if (contact.count == 0) return;
  ATL_ASSERT(manifold.friction_radius >= 0, slot, manifold.friction_radius);
  const double length = std::hypot(manifold.normal[0], manifold.normal[1], manifold.normal[2]);
  ATL_ASSERT(std::abs(length - 1) < float_rounding, slot, length);
  for (std::size_t i = 0; i < contact.count; ++i) {
    ATL_ASSERT(std::isfinite(manifold.separation[i]), slot, i, manifold.separation[i]);
    ATL_ASSERT(std::isfinite(manifold.normal_impulse[i]), slot, i, manifold.normal_impulse[i]);
  }
  for (std::size_t i = contact.count; i < collision::max_points; ++i) {
    ATL_ASSERT(manifold.normal_impulse[i] == 0, slot, i, manifold.normal_impulse[i]);
    ATL_ASSERT(contact.points[i][3] == collision::no_point, slot, i, contact.points[i][3]);
  }
}

void validate_contacts(const Stores& world) {
  const collision::ContactCache& cache = world.cache;
  ATL_ASSERT(cache.manifolds.size() == cache.contacts.size(), cache.manifolds.size(), cache.contacts.size());
  const std::span<const std::uint32_t> slots = cache.all_in_order();
  ATL_ASSERT(slots.size() == cache.size(), slots.size(), cache.size());
  for (std::size_t i = 0; i < slots.size(); ++i) {
    const std::uint32_t slot = slots[i];
    ATL_ASSERT(slot < cache.contacts.size(), slot, cache.contacts.size());
    const collision::Contact& contact = cache.contacts[slot];
    const collision::Pair pair = contact.pair;
    ATL_ASSERT(pair.second < world.colliders.size(), slot, pair.second, world.colliders.size());
    ATL_ASSERT(pair.first < pair.second, slot, pair.first, pair.second);
    ATL_ASSERT(world.colliders.body[pair.first] == contact.body_first, slot, pair.first, contact.body_first);
    ATL_ASSERT(world.colliders.body[pair.second] == contact.body_second, slot, pair.second, contact.body_second);
    ATL_ASSERT(contact.body_first != contact.body_second, slot, contact.body_first);
    ATL_ASSERT(cache.pairs.contains(pair), slot, pair.first, pair.second);
    if (i > 0) {
      const collision::Contact& before = cache.contacts[slots[i - 1]];
      ATL_ASSERT(before.pair < pair || (before.pair == pair && before.part < contact.part), slots[i - 1], slot);
    }
    // A restore leaves idle contacts without a manifold until they are active again.
    const bool is_active = world.active.contains(contact.body_first) || world.active.contains(contact.body_second);
    if (is_active) validate_manifold(contact, cache.manifolds[slot], slot);
  }
}

void validate_joints(const Stores& world) {
  const JointTable& joints = world.joints;
  ATL_ASSERT(joints.def.size() == joints.size(), joints.def.size(), joints.size());
  ATL_ASSERT(joints.generation.size() == joints.size(), joints.generation.size(), joints.size());
  ATL_ASSERT(joints.alive.size() == joints.size(), joints.alive.size(), joints.size());
  ATL_ASSERT(joints.enabled.size() == joints.size(), joints.enabled.size(), joints.size());
  ATL_ASSERT(joints.broken.size() == joints.size(), joints.broken.size(), joints.size());
  ATL_ASSERT(joints.suspended.size() == joints.size(), joints.suspended.size(), joints.size());
  ATL_ASSERT(joints.acts.size() == joints.size(), joints.acts.size(), joints.size());
  ATL_ASSERT(joints.watched.size() == joints.size(), joints.watched.size(), joints.size());
  ATL_ASSERT(joints.driven.size() == joints.size(), joints.driven.size(), joints.size());
  ATL_ASSERT(joints.limit_before.size() == joints.size(), joints.limit_before.size(), joints.size());
  for (const std::uint32_t joint : joints.free) {
    ATL_ASSERT(joint < joints.size() && !joints.alive[joint], joint, joints.size());
  }
  std::size_t alive = 0;
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    ATL_ASSERT(joints.alive[joint] || !joints.acts[joint], joint);
    ATL_ASSERT(joints.acts[joint] || !(joints.watched[joint] || joints.driven[joint]), joint);
    ATL_ASSERT(joints.def[joint] != nullptr, joint);
    ATL_ASSERT(!(joints.acts[joint] && (joints.broken[joint] || joints.suspended[joint] > 0)), joint,
               joints.suspended[joint]);
    if (!joints.alive[joint]) continue;
    ++alive;
    const solver::Joint& of = joints.joints[joint];
    ATL_ASSERT(!(joints.enabled[joint] && joints.broken[joint]), joint);
    ATL_ASSERT(of.rows <= solver::max_joint_rows, joint, of.rows);
    ATL_ASSERT(of.terms <= of.term.size(), joint, of.terms);
    for (std::size_t i = 0; i < of.terms; ++i) {
      ATL_ASSERT(of.term[i].joint < joints.size() && joints.alive[of.term[i].joint], joint, i, of.term[i].joint);
    }
    if (of.is_tendon()) continue;
    ATL_ASSERT(of.first < world.bodies.size() && world.records.alive[of.first], joint, of.first);
    ATL_ASSERT(of.second < world.bodies.size() && world.records.alive[of.second], joint, of.second);
    ATL_ASSERT(of.first != of.second, joint, of.first);
  }
  ATL_ASSERT(alive == joints.count, alive, joints.count);
}

}  // namespace

void validate(const Stores& world) {
  validate_bodies(world);
  validate_sleeping(world);
  validate_colliders(world);
  validate_contacts(world);
  if (world.joints.size() > 0) validate_joints(world);
}

}  // namespace atl
