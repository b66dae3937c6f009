// Bodies coming, going and being changed from outside.

#include <atoll/error.h>

#include <algorithm>
#include <sstream>

#include "body_definition.h"
#include "world_impl.h"

namespace atl {
namespace {

solver::Mobility mobility_of(BodyType type) {
  switch (type) {
    case BodyType::Static:
      return solver::Mobility::Fixed;
    case BodyType::Kinematic:
      return solver::Mobility::Kinematic;
    case BodyType::Dynamic:
      break;
  }
  return solver::Mobility::Dynamic;
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
}

BodyId World::Impl::add_body(const BodyDef& def) {
  const CheckedBody checked = check(def);
  std::uint32_t body;
  if (records.free.empty()) {
    body = static_cast<std::uint32_t>(bodies.size());
    const std::size_t count = body + std::size_t{1};
    bodies.resize(count);
    sleeping.resize(count);
    records.generation.resize(count, 0);
    records.alive.resize(count, 0);
    records.type.resize(count, BodyType::Static);
    records.shape.resize(count);
    records.material.resize(count);
  } else {
    body = records.free.back();
    records.free.pop_back();
  }
  records.alive[body] = 1;
  records.type[body] = def.type;
  records.shape[body] = checked.shape;
  records.material[body] = def.material;
  ++records.count;

  bodies.mobility[body] = mobility_of(def.type);
  bodies.position(body) = checked.position;
  bodies.set_orientation(body, checked.orientation);
  bodies.velocity(body) = def.velocity;
  bodies.angular_velocity(body) = def.angular_velocity;
  bodies.force(body).setZero();
  bodies.torque(body).setZero();
  bodies.inverse_mass[body] = checked.inverse_mass;
  bodies.inertia[body] = checked.inertia;
  bodies.inverse_inertia[body] = checked.inverse_inertia;
  bodies.gyroscopic[body] = checked.gyroscopic;
  bodies.ball[body] = checked.shape.kind == collision::ShapeKind::Sphere;
  bodies.gravity_scale[body] = def.gravity_scale;
  bodies.linear_damping[body] = def.linear_damping;
  bodies.angular_damping[body] = def.angular_damping;

  sleeping.awake[body] = def.type == BodyType::Dynamic;
  sleeping.rest_time[body] = 0;
  contents.count(bodies, records, body, +1);
  add_proxy(body);
  return {body, records.generation[body]};
}

void World::Impl::remove_body(BodyId id) {
  const std::uint32_t body = index_of(id, "remove_body");
  wake_touching(body);
  sleeping.wake(body);
  cache.remove_if([&](std::uint32_t slot) {
    const collision::Pair pair = cache.contacts[slot].pair;
    return pair.first == body || pair.second == body;
  });
  broadphase.remove(body);
  contents.count(bodies, records, body, -1);
  sleeping.awake[body] = 0;
  bodies.mobility[body] = solver::Mobility::Fixed;
  bodies.gyroscopic[body] = 0;
  bodies.velocity(body).setZero();
  bodies.angular_velocity(body).setZero();
  records.alive[body] = 0;
  ++records.generation[body];
  records.free.push_back(body);
  --records.count;
  contact_forces_valid_ = false;
}

std::uint32_t World::Impl::index_of(BodyId id, const char* call) const {
  if (id.index < bodies.size() && records.alive[id.index] && records.generation[id.index] == id.generation) {
    return id.index;
  }
  std::ostringstream message;
  message << "World::" << call << ": no body has the id (index " << id.index << ", generation " << id.generation
          << "); expected the id of a body that has not been removed";
  throw Error(message.str());
}

std::uint32_t World::Impl::awaken(BodyId id, const char* call) {
  const std::uint32_t body = index_of(id, call);
  sleeping.wake(body);
  return body;
}

void World::Impl::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t body = index_of(id, "set_pose");
  check_finite("World::set_pose: pose.position", pose.position);
  const Quaternion orientation = checked_orientation("World::set_pose: pose.orientation", pose.orientation);
  wake_touching(body);
  sleeping.wake(body);
  bodies.position(body) = pose.position;
  bodies.set_orientation(body, orientation);
  move_proxy(body);
}

void World::Impl::wake_all() {
  for (std::uint32_t body = 0; body < bodies.size(); ++body) sleeping.wake(body);
}

void World::Impl::wake_touching(std::uint32_t body) {
  for (const std::uint32_t slot : cache.order) {
    const collision::Contact& contact = cache.contacts[slot];
    if (contact.count == 0) continue;
    if (contact.pair.first == body) sleeping.wake(contact.pair.second);
    if (contact.pair.second == body) sleeping.wake(contact.pair.first);
  }
}

// The box needed now: bounds, grown by the speculative margin and where the body may get to in a step. And the
// fat one: with some slack, so that it needn't be asked again at once.
World::Impl::ProxyBoxes World::Impl::proxy_boxes(std::uint32_t body) const {
  const collision::Shape& shape = records.shape[body];
  const collision::Bounds bounds =
      collision::bounds_of(shape, bodies.position(body), bodies.orientation(body).toRotationMatrix());
  const double reach =
      (bodies.velocity(body).norm() + bodies.angular_velocity(body).norm() * shape.bounding_radius) * dt_;
  const Vector3 margin = Vector3::Constant(collision::speculative_margin(shape, shape, reach));
  // 15% of the inner radius is 7.5 cm for a cube of 1 m.
  const Vector3 slack = margin + Vector3::Constant(0.15 * shape.inner_radius);
  return {collision::Aabb::around(bounds.lower - margin, bounds.upper + margin),
          collision::Aabb::around(bounds.lower - slack, bounds.upper + slack)};
}

bool World::Impl::is_finite(std::uint32_t body) const {
  return bodies.position(body).allFinite() && bodies.orientation(body).coeffs().allFinite();
}

collision::Plane World::Impl::world_plane(std::uint32_t body) const {
  const collision::Shape& shape = records.shape[body];
  const Vector3 normal = bodies.orientation(body) * shape.normal;
  return {normal, shape.offset + normal.dot(bodies.position(body))};
}

void World::Impl::add_proxy(std::uint32_t body) {
  if (records.shape[body].kind == collision::ShapeKind::HalfSpace) {
    broadphase.add_half_space(body, world_plane(body));
  } else {
    broadphase.add_box(body, proxy_boxes(body).fat, bodies.mobility[body] == solver::Mobility::Fixed);
  }
}

void World::Impl::move_proxy(std::uint32_t body) {
  if (broadphase.is_half_space(body)) {
    broadphase.move_half_space(body, world_plane(body));
  } else {
    broadphase.move_box(body, proxy_boxes(body).fat);
  }
}

}  // namespace atl
