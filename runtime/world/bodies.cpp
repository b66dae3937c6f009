// Bodies coming, going and being changed from outside.

#include <atoll/error.h>
#include <collision/narrowphase/surface_contacts.h>
#include <jobs/with_direct_contacts.h>
#include <jobs/with_joints.h>
#include <jobs/with_recording.h>
#include <solver/constraints/motion_locks.h>

#include <algorithm>
#include <string>

#include "state/recorder.h"
#include "state/roster.h"
#include "world/body_definition.h"
#include "world/refuse.h"
#include "world/world_impl.h"

namespace atl {
namespace {

collision::Filter to_collision(const CollisionFilter& filter, std::uint32_t body) {
  return {filter.category, filter.mask, filter.group, body};
}

// Whether a shape looks the same turned about the z axis of its body's frame.
bool is_round(const CheckedCollider& collider) {
  const auto& [position, orientation] = collider.local;
  if (position.x() != 0 || position.y() != 0) return false;
  switch (collider.shape.kind) {
    case collision::ShapeKind::Sphere:
      return true;
    case collision::ShapeKind::Capsule:
    case collision::ShapeKind::Cylinder:
    case collision::ShapeKind::Cone:
      return orientation.x() == 0 && orientation.y() == 0;
    default:
      return false;
  }
}

}  // namespace

void Contents::count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign) {
  const auto add = [sign](std::size_t& counter, bool has) {
    if (has) counter += static_cast<std::size_t>(sign);
  };
  add(kinematic, bodies.mobility[body] == solver::Mobility::Kinematic);
  add(with_friction, records.material[body].friction > 0);
  add(with_restitution, records.material[body].restitution > 0);
  add(gyroscopic, bodies.gyroscopic[body] != 0);
  const auto smooth = [](const CheckedCollider& collider) { return collision::is_smooth(collider.shape); };
  const std::vector<CheckedCollider>& colliders = records.constants[body]->colliders;
  add(smooth_surfaces, std::any_of(colliders.begin(), colliders.end(), smooth));
}

void BodyRecords::resize(std::size_t bodies) {
  jobs::append(generation, bodies, std::uint32_t{0});
  jobs::append(alive, bodies, std::uint8_t{0});
  jobs::append(type, bodies, BodyType::Static);
  jobs::append(dynamic, bodies, std::uint8_t{0});
  material.resize(bodies);
  centre.resize(bodies);
  jobs::append(continuous, bodies, std::uint8_t{0});
  jobs::append(constants, bodies);
}

void World::Impl::resize_bodies(std::size_t count) {
  bodies.resize(count);
  records.resize(count);
  sleeping.resize(count);
  quarantine.resize(count);
  active_.resize(count);
  aabbs.resize(count);
  colliders.resize_bodies(count);
}

// What the body is for as long as it lives.
void World::Impl::give_constants(std::uint32_t body, const std::shared_ptr<const BodyConstants>& constants) {
  records.constants[body] = constants;
  const BodyConstants& c = *constants;
  records.alive[body] = 1;
  records.type[body] = c.type;
  records.dynamic[body] = c.type == BodyType::Dynamic;
  records.material.set(body, c.material);
  records.centre.set(body, c.centre);
  records.continuous[body] = c.continuous;
  bodies.mobility[body] = mobility_of(c.type);
  bodies.inverse_mass[body] = c.inverse_mass;
  bodies.inertia.set(body, c.inertia);
  bodies.inverse_inertia.set(body, c.inverse_inertia);
  bodies.gyroscopic[body] = c.gyroscopic;
  bodies.locks[body] = c.locks;
  bodies.principal_axes.set(body, c.principal_axes);
  bodies.moments.set(body, c.moments);
  const double least_moment = least_moment_of(c);
  if (least_moment > 0 && bodies.least_moment.empty()) bodies.least_moment.resize(bodies.size(), 0.0);
  if (!bodies.least_moment.empty()) bodies.least_moment[body] = least_moment;
  bodies.ball[body] = c.colliders.size() == 1 && c.colliders.front().shape.kind == collision::ShapeKind::Sphere &&
                      c.centre.isZero(0) && c.colliders.front().local.position.isZero(0);
  bodies.round[body] = !bodies.ball[body] && std::all_of(c.colliders.begin(), c.colliders.end(), is_round);
  bodies.gravity_scale[body] = c.gravity_scale;
  bodies.linear_damping[body] = c.linear_damping;
  bodies.angular_damping[body] = c.angular_damping;
}

BodyId World::Impl::add_body(const CheckedBody& start) {
  std::uint32_t body;
  if (records.free.empty()) {
    body = static_cast<std::uint32_t>(bodies.size());
    resize_bodies(body + std::size_t{1});
  } else {
    body = records.free.back();
    records.free.pop_back();
  }
  ++records.count;
  forget_roster();
  give_constants(body, constants_.share(start.constants));

  bodies.position(body) = start.position + start.orientation * records.centre[body];
  bodies.set_orientation(body, start.orientation);
  bodies.velocity(body) = start.velocity;
  bodies.angular_velocity(body) = start.angular_velocity;
  bodies.force(body).setZero();
  bodies.torque(body).setZero();
  run_surface(body, start.surface_velocity);

  sleeping.awake[body] = records.dynamic[body];
  sleeping.rest_time[body] = 0;
  if (records.dynamic[body]) selection_.arrive(body);
  contents.count(bodies, records, body, +1);
  note_arrival_or_departure(body);
  add_colliders(body);
  note_size(body);
  add_proxies(body, to_collision(start.filter, body));
  suspect_new(body);
  if constexpr (with_recording) {
    if (recorder) recorder->note_body(start, fingerprint(start.constants));
  }
  return {body, records.generation[body]};
}

void World::Impl::remove_body(BodyId id) {
  captured_ = false;
  const std::uint32_t body = index_of(id, "remove_body");
  if constexpr (with_joints) remove_joints_of(body);
  if (quarantine.contains(body)) {
    quarantine.remove(body);
  } else {
    take_out(body);
  }
  remove_colliders(body);
  records.constants[body].reset();
  forget_roster();
  bodies.velocity(body).setZero();
  bodies.angular_velocity(body).setZero();
  records.alive[body] = 0;
  ++records.generation[body];
  records.free.push_back(body);
  --records.count;
}

// From all that a step goes through, but for joints, which go before. What touched the body wakes.
void World::Impl::take_out(std::uint32_t body) {
  wake_touching(body);
  sleeping.wake(body);
  cache.remove_contacts_of(body);
  aabbs.remove(body, colliders, broadphase);
  contents.count(bodies, records, body, -1);
  sleeping.awake[body] = 0;
  if constexpr (with_direct_contacts) selection_.forget(body);
  records.dynamic[body] = 0;
  note_arrival_or_departure(body);
  bodies.mobility[body] = solver::Mobility::Fixed;
  bodies.gyroscopic[body] = 0;
  bodies.velocity(body).setZero();
  bodies.angular_velocity(body).setZero();
  contact_forces_valid_ = false;
}

std::uint32_t World::Impl::index_of(BodyId id, const char* call) const {
  if (id.index < bodies.size() && records.alive[id.index] && records.generation[id.index] == id.generation) {
    return id.index;
  }
  refuse_stale(std::string("World::") + call, id);
}

std::uint32_t World::Impl::awaken(BodyId id, const char* call) { return awaken(index_of(id, call)); }

std::uint32_t World::Impl::awaken(std::uint32_t body) {
  sleeping.wake(body);
  aabbs.mark_dirty(body);
  quarantine.suspect(body);
  if (bodies.mobility[body] == solver::Mobility::Kinematic) may_start_or_stop_.push_back(body);
  return body;
}

void World::Impl::apply_force(std::uint32_t body, const Vector3& force, const Vector3& torque) {
  if (quarantine.contains(body)) return;
  if (bodies.force(body).isZero(0) && bodies.torque(body).isZero(0)) pushed_.push_back(body);
  bodies.force(body) += force;
  bodies.torque(body) += torque;
}

void World::Impl::apply_impulse(std::uint32_t body, const Vector3& impulse, const Vector3& moment) {
  if (quarantine.contains(body)) return;
  bodies.velocity(body) +=
      bodies.inverse_mass[body] * solver::without(solver::linear_locks(bodies.locks[body]), impulse);
  bodies.angular_velocity(body) += solver::angular_response(bodies, body, moment);
}

Pose World::Impl::pose(BodyId id) const {
  const std::uint32_t body = index_of(id, "pose");
  const Quaternion orientation = bodies.orientation(body);
  const Vector3& centre = records.centre[body];
  const Vector3 position = bodies.position(body);
  return {centre.isZero(0) ? position : Vector3(position - orientation * centre), orientation};
}

void World::Impl::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t body = index_of(id, "set_pose");
  check_finite("World::set_pose: pose.position", pose.position);
  const Quaternion orientation = checked_orientation("World::set_pose: pose.orientation", pose.orientation);
  wake_touching(body);
  if constexpr (with_joints) wake_joined(body);
  sleeping.wake(body);
  const Vector3 position = pose.position + orientation * records.centre[body];
  before_move(body, position);
  bodies.position(body) = position;
  const double turn = solver::turn_chord(bodies.orientation(body), orientation);
  const bool fixed = bodies.mobility[body] == solver::Mobility::Fixed;
  bodies.turned[body] += fixed && turn > 0 ? collision::put_elsewhere : turn;
  bodies.set_orientation(body, orientation);
  move_proxies(body);
}

void World::Impl::set_surface(std::uint32_t body, const solver::Surface& surface) {
  if (!surface.is_plain() && bodies.surfaces.empty()) bodies.surfaces.resize(bodies.size());
  if (!bodies.surfaces.empty()) bodies.surfaces[body] = surface;
}

void World::Impl::run_surface(std::uint32_t body, const Vector3& velocity) {
  const Material& material = records.material[body];
  set_surface(body, {velocity, material.rolling_friction, material.torsional_friction});
}

void World::Impl::set_surface_velocity(BodyId id, const Vector3& velocity) {
  const std::uint32_t body = index_of(id, "set_surface_velocity");
  wake_touching(body);
  sleeping.wake(body);
  quarantine.suspect(body);
  run_surface(body, velocity);
}

void World::Impl::set_filter(BodyId id, const CollisionFilter& filter) {
  const std::uint32_t body = index_of(id, "set_filter");
  wake_touching(body);
  sleeping.wake(body);
  const collision::Filter in_broadphase = to_collision(filter, body);
  if (quarantine.contains(body)) {
    quarantine.kept(body).filter = in_broadphase;
    return;
  }
  colliders.for_each_of(body, [&](std::uint32_t collider) { broadphase.set_filter(collider, in_broadphase); });
}

void World::Impl::set_collision_enabled(BodyId a, BodyId b, bool enabled) {
  const std::uint32_t first = index_of(a, "set_collision_enabled");
  const std::uint32_t second = index_of(b, "set_collision_enabled");
  if (first == second) throw Error("World::set_collision_enabled: both bodies are the same; expected two bodies");
  sleeping.wake(first);
  sleeping.wake(second);
  std::vector<std::uint32_t>& of_first = records.ignored[first];
  std::vector<std::uint32_t>& of_second = records.ignored[second];
  std::erase(of_first, second);
  std::erase(of_second, first);
  if (enabled) {
    if (!with_joints || !joints.are_kept_apart(first, second)) broadphase.unignore(first, second);
  } else {
    of_first.insert(std::lower_bound(of_first.begin(), of_first.end(), second), second);
    of_second.insert(std::lower_bound(of_second.begin(), of_second.end(), first), first);
    broadphase.ignore(first, second);
  }
}

void World::Impl::wake_all() {
  for (std::uint32_t body = 0; body < bodies.size(); ++body) sleeping.wake(body);
}

void World::Impl::wake_touching(std::uint32_t body) {
  cache.for_each_contact_of(body, [&](std::uint32_t slot) {
    const collision::Contact& contact = cache.contacts[slot];
    if (contact.count == 0) return;
    if (contact.body_first == body) sleeping.wake(contact.body_second);
    if (contact.body_second == body) sleeping.wake(contact.body_first);
  });
}

// Islands are made anew even if the index was used again for a body that looks the same to them.
void World::Impl::note_arrival_or_departure(std::uint32_t body) {
  if (bodies.mobility[body] != solver::Mobility::Fixed || active_.contains(body)) may_start_or_stop_.push_back(body);
  islands_stale_ = true;
}

}  // namespace atl
