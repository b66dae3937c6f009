#include "world/bodies.h"

#include <features/with_direct_contacts.h>
#include <features/with_joints.h>
#include <jobs/assert.h>
#include <solver/constraints/contact_arm.h>
#include <solver/integrate/motion_locks.h>

#include <algorithm>
#include <string>

#include "world/body_definition.h"
#include "world/colliders.h"
#include "world/containment.h"
#include "world/joints.h"
#include "world/refuse.h"

namespace atl {
namespace {

// Drops the reported contact forces of a body; those between other bodies stay.
void forget_contact_forces(Stores& world, std::uint32_t body) {
  std::erase_if(world.results.contact_forces,
                [body](const ContactForce& force) { return force.a.index == body || force.b.index == body; });
}

// The body begins where another one has been, or nobody was.
void forget_acceleration(Stores& world, std::uint32_t body) {
  for (std::vector<double>* of : {&world.results.accelerations.linear, &world.results.accelerations.angular}) {
    if (of->empty()) continue;
    of->resize(3 * world.bodies.size());
    std::fill_n(of->data() + 3 * std::size_t{body}, 3, 0.0);
  }
}

// Drops the contact filter's answers about a body's shapes, and its open questions.
void forget_choices(Stores& world, std::uint32_t body) {
  ContactChoices& choices = world.choices;
  if (choices.is_empty()) return;
  const auto is_own = [&](std::uint32_t collider) { return world.colliders.body[collider] == body; };
  std::erase_if(choices.refused, [&](collision::Pair pair) { return is_own(pair.first) || is_own(pair.second); });
  std::erase(choices.refiltered, body);
}

}  // namespace

void forget_contacts(Stores& world, std::uint32_t body) {
  world.cache.remove_contacts_of(body);
  forget_choices(world, body);
  forget_contact_forces(world, body);
}

void resize_bodies(Stores& world, std::size_t count) {
  world.bodies.resize(count);
  world.records.resize(count);
  world.sleeping.resize(count);
  world.quarantine.resize(count);
  world.active.resize(count);
  world.aabbs.resize(count);
  world.colliders.resize_bodies(count);
}

// Stores the constants of a body.
void give_constants(Stores& world, std::uint32_t body, const std::shared_ptr<const BodyConstants>& constants) {
  BodyRecords& records = world.records;
  solver::BodyTable& bodies = world.bodies;
  records.constants[body] = constants;
  const BodyConstants& c = *constants;
  records.alive[body] = 1;
  records.type[body] = c.type;
  records.dynamic[body] = c.type == BodyType::Dynamic;
  records.material.set(body, c.material);
  records.centre.set(body, c.centre);
  records.continuous[body] = c.continuous;
  records.sensor[body] = c.sensor;
  bodies.mobility[body] = mobility_of(c.type);
  bodies.inverse_mass[body] = c.inverse_mass;
  bodies.inertia.set(body, c.inertia);
  bodies.inverse_inertia.set(body, c.inverse_inertia);
  bodies.gyroscopic[body] = c.gyroscopic;
  bodies.locks[body] = c.locks;
  world.sleeping.keep_awake(body, !c.may_sleep);
  bodies.principal_axes.set(body, c.principal_axes);
  bodies.moments.set(body, c.moments);
  const double min_moment = min_moment_of(c);
  if (min_moment > 0 && bodies.min_moment.empty()) bodies.min_moment.resize(bodies.size(), 0.0);
  if (!bodies.min_moment.empty()) bodies.min_moment[body] = min_moment;
  bodies.ball[body] = c.colliders.size() == 1 && c.colliders.front().shape.kind == collision::ShapeKind::Sphere &&
                      c.centre.isZero(0) && c.colliders.front().local.position.isZero(0);
  bodies.rolls[body] = !bodies.ball[body] && std::ranges::any_of(c.colliders, [](const CheckedCollider& collider) {
    return solver::is_round(collider.shape.kind);
  });
  bodies.gravity_scale[body] = c.gravity_scale;
  bodies.linear_damping[body] = c.linear_damping;
  bodies.angular_damping[body] = c.angular_damping;
}

BodyId add_body(Stores& world, const CheckedBody& start) {
  solver::BodyTable& bodies = world.bodies;
  BodyRecords& records = world.records;
  std::uint32_t body;
  if (records.free.empty()) {
    body = static_cast<std::uint32_t>(bodies.size());
    resize_bodies(world, body + std::size_t{1});
  } else {
    body = records.free.back();
    records.free.pop_back();
  }
  ATL_ASSERT(body < bodies.size() && !records.alive[body], body, bodies.size());
  ATL_ASSERT(world.colliders.first[body] == collision::ColliderTable::none, body, world.colliders.first[body]);
  ATL_ASSERT(!world.sleeping.is_asleep(body) && !world.quarantine.contains(body), body);
  ++records.count;
  ++records.version;
  give_constants(world, body, records.pool.share(start.constants));

  bodies.position(body) = start.position + start.orientation * records.centre[body];
  bodies.set_orientation(body, start.orientation);
  bodies.velocity(body) = start.velocity;
  bodies.angular_velocity(body) = start.angular_velocity;
  bodies.clear_push(body);
  records.user_data[body] = start.user_data;
  give_name(world, body, start.name);
  records.filter.set(body, start.filter);
  run_surface(world, body, start.surface);

  world.sleeping.awake[body] = records.dynamic[body];
  world.sleeping.rest_time[body] = 0;
  world.contents.count(bodies, records, body, +1);
  mark_arrival_or_departure(world, body);
  add_colliders(world, body);
  update_size(world, body);
  add_proxies(world, body);
  suspect_new(world, body);
  forget_acceleration(world, body);
  if (!start.awake && world.settings.sleeping) {
    world.sleeping.put_to_sleep(std::span(&body, 1), bodies);
    world.sleeping.mark_reported(body);
  }
  return {body, records.generation[body]};
}

void remove_body(Stores& world, std::uint32_t body) {
  solver::BodyTable& bodies = world.bodies;
  BodyRecords& records = world.records;
  ATL_ASSERT(records.alive[body] && records.count > 0, body, records.count);
  world.results.captured = false;
  if constexpr (with_joints) remove_joints_of(world, body);
  if (world.quarantine.contains(body)) {
    world.quarantine.remove(body);
  } else {
    take_out(world, body);
  }
  world.sleeping.mark_reported(body);
  remove_colliders(world, body);
  records.constants[body].reset();
  records.names.erase(body);
  ++records.version;
  bodies.velocity(body).setZero();
  bodies.angular_velocity(body).setZero();
  records.alive[body] = 0;
  ++records.generation[body];
  records.free.push_back(body);
  --records.count;
}

// From all that a step goes through, but for joints, which go before. What touched the body wakes.
void take_out(Stores& world, std::uint32_t body) {
  solver::BodyTable& bodies = world.bodies;
  BodyRecords& records = world.records;
  wake_touching(world, body);
  world.sleeping.wake(body);
  forget_contacts(world, body);
  world.aabbs.remove(body, world.colliders, world.broadphase);
  world.contents.count(bodies, records, body, -1);
  world.sleeping.awake[body] = 0;
  if constexpr (with_direct_contacts) world.selection.forget(body);
  world.control.forget(body);
  records.dynamic[body] = 0;
  mark_arrival_or_departure(world, body);
  bodies.mobility[body] = solver::Mobility::Fixed;
  bodies.gyroscopic[body] = 0;
  bodies.velocity(body).setZero();
  bodies.angular_velocity(body).setZero();
}

bool contains(const Stores& world, BodyId id) {
  return id.index < world.bodies.size() && world.records.alive[id.index] &&
         world.records.generation[id.index] == id.generation;
}

std::uint32_t index_of(const Stores& world, BodyId id, const char* call) {
  if (contains(world, id)) return id.index;
  refuse_stale(std::string("World::") + call, id);
}

std::uint32_t awaken(Stores& world, std::uint32_t body) {
  world.sleeping.wake(body);
  world.aabbs.mark_dirty(body);
  world.quarantine.suspect(body);
  if (world.bodies.mobility[body] == solver::Mobility::Kinematic) world.changes.may_start_or_stop.push_back(body);
  return body;
}

void apply_force(Stores& world, std::uint32_t body, const Vector3& force, const Vector3& torque) {
  if (world.quarantine.contains(body)) return;
  if (world.bodies.force(body).isZero(0) && world.bodies.torque(body).isZero(0)) world.changes.pushed.push_back(body);
  world.bodies.push(body, force, torque);
}

void clear_forces(Stores& world) {
  for (const std::uint32_t body : world.changes.pushed) world.bodies.clear_push(body);
  world.changes.pushed.clear();
}

namespace {

Vector3 linear_response(const solver::BodyTable& bodies, std::uint32_t body, const Vector3& impulse) {
  return bodies.inverse_mass[body] * solver::without(solver::linear_locks(bodies.locks[body]), impulse);
}

}  // namespace

void apply_impulse(Stores& world, std::uint32_t body, const Vector3& impulse, const Vector3& moment) {
  if (world.quarantine.contains(body)) return;
  world.bodies.velocity(body) += linear_response(world.bodies, body, impulse);
  world.bodies.angular_velocity(body) += solver::angular_response(world.bodies, body, moment);
}

void check_impulse(const Stores& world, std::uint32_t body, const Vector3& impulse, const Vector3& moment) {
  if (world.quarantine.contains(body)) return;
  const solver::BodyTable& bodies = world.bodies;
  check_finite("World::apply_impulse: the velocity after it",
               Vector3(bodies.velocity(body) + linear_response(bodies, body, impulse)));
  check_finite("World::apply_impulse: the angular velocity after it",
               Vector3(bodies.angular_velocity(body) + solver::angular_response(bodies, body, moment)));
}

BodyDef definition_of(const Stores& world, std::uint32_t body) {
  const BodyConstants& constants = *world.records.constants[body];
  const Pose pose = pose_of(world, body);
  BodyDef def{.type = constants.type,
              .shape = shape_of(constants),
              .position = pose.position,
              .orientation = pose.orientation,
              .velocity = world.bodies.velocity(body),
              .angular_velocity = world.bodies.angular_velocity(body),
              .material = constants.material,
              .materials = constants.materials,
              .gravity_scale = constants.gravity_scale,
              .linear_damping = constants.linear_damping,
              .angular_damping = constants.angular_damping,
              .locks = locks_of(constants.locks),
              .max_speed = constants.max_speed,
              .max_angular_speed = constants.max_angular_speed,
              .awake = !world.sleeping.is_asleep(body),
              .may_sleep = constants.may_sleep,
              .filter = world.records.filter[body],
              .continuous = constants.continuous,
              .sensor = constants.sensor,
              .notices_static = constants.notices_static,
              .notices_sensors = constants.notices_sensors,
              .contact_event_force = constants.contact_event_force,
              .user_data = world.records.user_data[body]};
  if (constants.type == BodyType::Dynamic) {
    def.mass = std::clamp(1 / constants.inverse_mass, loads.min, loads.max);  // to rounding it is
    def.inertia = constants.inertia;
    def.centre_of_mass = constants.centre;
  }
  const solver::SurfaceMotion surface = surface_motion(world, body);
  def.surface_velocity = surface.velocity;
  def.surface_angular_velocity = surface.angular_velocity;
  if (const auto named = world.records.names.find(body); named != world.records.names.end()) def.name = named->second;
  return def;
}

Pose pose_of(const Stores& world, std::uint32_t body) {
  const Quaternion orientation = world.bodies.orientation(body);
  const Vector3& centre = world.records.centre[body];
  const Vector3 position = world.bodies.position(body);
  return {centre.isZero(0) ? position : Vector3(position - orientation * centre), orientation};
}

void set_pose(Stores& world, std::uint32_t body, const Vector3& origin, const Quaternion& orientation) {
  ATL_ASSERT(!(std::abs(orientation.squaredNorm() - 1) > 1e-9), body, orientation.norm());
  wake_touching(world, body);
  if constexpr (with_joints) wake_joined(world, body);
  world.sleeping.wake(body);
  const Vector3 position = origin + orientation * world.records.centre[body];
  before_move(world, body, position);
  world.bodies.position(body) = position;
  const double turn = solver::turn_chord(world.bodies.orientation(body), orientation);
  const bool fixed = world.bodies.mobility[body] == solver::Mobility::Fixed;
  world.bodies.turned[body] += fixed && turn > 0 ? collision::put_elsewhere : turn;
  world.bodies.set_orientation(body, orientation);
  move_proxies(world, body);
}

namespace {

void set_surface(Stores& world, std::uint32_t body, const solver::Surface& surface) {
  if (!surface.is_plain() && world.bodies.surfaces.empty()) world.bodies.surfaces.resize(world.bodies.size());
  if (!world.bodies.surfaces.empty()) world.bodies.surfaces[body] = surface;
}

}  // namespace

solver::SurfaceMotion surface_motion(const Stores& world, std::uint32_t body) {
  return world.bodies.surfaces.empty() ? solver::SurfaceMotion{} : world.bodies.surfaces[body].motion;
}

void run_surface(Stores& world, std::uint32_t body, const solver::SurfaceMotion& motion) {
  solver::Surface surface{.motion = motion, .centre = world.records.centre[body]};
  for_each_material(*world.records.constants[body], [&](const Material& material) {
    surface.rolling_friction = std::max(surface.rolling_friction, material.rolling_friction);
    surface.torsional_friction = std::max(surface.torsional_friction, material.torsional_friction);
    surface.uneven |= material.is_directed();
  });
  set_surface(world, body, surface);
}

void set_surface_velocity(Stores& world, std::uint32_t body, const solver::SurfaceMotion& motion) {
  wake_touching(world, body);
  world.sleeping.wake(body);
  world.quarantine.suspect(body);
  run_surface(world, body, motion);
}

namespace {

// Colliders refer to the geometry of the constants that the body has now: equal to what it had, and elsewhere in
// memory.
void refer_to_geometry(Stores& world, std::uint32_t body) {
  const BodyConstants& constants = *world.records.constants[body];
  world.colliders.for_each_of(body, [&](std::uint32_t collider) {
    const CheckedCollider& part = constants.colliders[world.colliders.child[collider]];
    world.colliders.shape.set(collider, part.in_frame_of(constants.centre).shape);
  });
}

}  // namespace

void exchange_constants(Stores& world, std::uint32_t body, const BodyConstants& constants) {
  BodyRecords& records = world.records;
  const bool takes_part = !world.quarantine.contains(body);
  if (takes_part) world.contents.count(world.bodies, records, body, -1);
  give_constants(world, body, records.pool.share(constants));
  refer_to_geometry(world, body);
  if (takes_part) {
    world.contents.count(world.bodies, records, body, +1);
  } else {
    records.dynamic[body] = 0;
    world.bodies.mobility[body] = solver::Mobility::Fixed;
    world.bodies.gyroscopic[body] = 0;
  }
  ++records.version;
  run_surface(world, body, surface_motion(world, body));
}

void change_constants(Stores& world, std::uint32_t body, const BodyConstants& constants) {
  exchange_constants(world, body, constants);
  world.cache.for_each_contact_of(body, [&](std::uint32_t slot) { mix_materials(world, slot); });
  wake_touching(world, body);
  world.sleeping.wake(body);
  world.changes.islands = true;
  if (with_joints && world.joints.size() > 0) world.changes.joints = true;
}

void give_name(Stores& world, std::uint32_t body, std::string_view name) {
  if (name.empty()) {
    world.records.names.erase(body);
  } else {
    world.records.names.insert_or_assign(body, std::string(name));
  }
}

void set_filter(Stores& world, std::uint32_t body, const CollisionFilter& filter) {
  wake_touching(world, body);
  world.sleeping.wake(body);
  world.records.filter.set(body, filter);
  if (world.quarantine.contains(body)) return;
  world.colliders.for_each_of(
      body, [&](std::uint32_t collider) { world.broadphase.set_filter(collider, filter_of(world, collider)); });
}

void refilter(Stores& world, std::uint32_t body) {
  wake_touching(world, body);
  world.sleeping.wake(body);
  if (world.quarantine.contains(body)) return;
  std::vector<std::uint32_t>& bodies = world.choices.refiltered;
  const auto place = std::lower_bound(bodies.begin(), bodies.end(), body);
  if (place == bodies.end() || *place != body) bodies.insert(place, body);
}

void set_collision_enabled(Stores& world, std::uint32_t first, std::uint32_t second, bool enabled) {
  world.sleeping.wake(first);
  world.sleeping.wake(second);
  if (enabled) {
    world.records.enable_pair(first, second);
    if (!with_joints || !world.joints.are_kept_apart(first, second)) world.broadphase.enable_pair(first, second);
  } else {
    world.records.disable_pair(first, second);
    world.broadphase.disable_pair(first, second);
  }
}

void wake_all(Stores& world) {
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) world.sleeping.wake(body);
}

void wake_touching(Stores& world, std::uint32_t body) {
  world.cache.for_each_contact_of(body, [&](std::uint32_t slot) {
    const collision::Contact& contact = world.cache.contacts[slot];
    if (contact.count == 0) return;
    if (contact.body_first == body) world.sleeping.wake(contact.body_second);
    if (contact.body_second == body) world.sleeping.wake(contact.body_first);
  });
}

// Islands are made anew even if the index was used again for a body that looks the same to them.
void mark_arrival_or_departure(Stores& world, std::uint32_t body) {
  if (world.bodies.mobility[body] != solver::Mobility::Fixed || world.active.contains(body))
    world.changes.may_start_or_stop.push_back(body);
  world.changes.islands = true;
}

namespace {

bool may_move(const Stores& world, std::uint32_t body) {
  const solver::BodyTable& bodies = world.bodies;
  if (bodies.mobility[body] != solver::Mobility::Kinematic) return world.sleeping.awake[body] != 0;
  return !(bodies.velocity(body).isZero(0) && bodies.angular_velocity(body).isZero(0));
}

}  // namespace

ActiveChange update_active_bodies(Stores& world) {
  std::vector<std::uint32_t>& may_have = world.changes.may_start_or_stop;
  may_have.insert(may_have.end(), world.sleeping.changed.begin(), world.sleeping.changed.end());
  world.sleeping.changed.clear();
  const bool changed = world.active.update(may_have, [&](std::uint32_t body) { return may_move(world, body); });
  may_have.clear();
  if (!changed) return {};
  world.reaches.resize(world.bodies.size());
  for (const std::uint32_t body : world.active.stopped()) world.reaches[body] = {};
  world.changes.islands = true;
  return {true, world.cache.set_active(world.active.started(), world.active.stopped())};
}

}  // namespace atl
