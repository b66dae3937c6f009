#include "world/redefine.h"

#include <atoll/error.h>
#include <features/with_direct_contacts.h>
#include <features/with_joints.h>
#include <solver/integrate/motion_locks.h>

#include <utility>

#include "state/world_definition.h"
#include "world/bodies.h"
#include "world/colliders.h"
#include "world/joints.h"

namespace atl {
namespace {

// All of a body that contacts and the broadphase go by.
std::uint64_t place_of(const BodyConstants& body) {
  BodyConstants place;
  place.type = body.type;
  place.continuous = body.continuous;
  place.sensor = body.sensor;
  place.centre = body.centre;
  for (CheckedCollider collider : body.colliders) {
    collider.material.reset();
    collider.density_factor = 1;
    place.colliders.push_back(std::move(collider));
  }
  return fingerprint(place);
}

// Shapes are in the broadphase as the body's type says, in a frame about its centre of mass.
void give_other_place(Stores& world, std::uint32_t body, const BodyConstants& constants) {
  const bool takes_part = !world.quarantine.contains(body);
  if (takes_part) {
    forget_contacts(world, body);
    world.aabbs.remove(body, world.colliders, world.broadphase);
  }
  clear_colliders(world, body);
  change_constants(world, body, constants);
  add_colliders(world, body);
  note_size(world, body);
  if (takes_part) add_proxies(world, body);
  world.results.captured = false;
}

// A body that its type or locks no longer let move or sleep stops.
void follow_type(Stores& world, std::uint32_t body) {
  solver::BodyTable& bodies = world.bodies;
  const BodyType type = world.records.type[body];
  if (type == BodyType::Static) {
    bodies.velocity(body).setZero();
    bodies.angular_velocity(body).setZero();
  } else if (const std::uint8_t locks = bodies.locks[body]; locks != 0) {
    bodies.velocity(body) = solver::without(solver::linear_locks(locks), bodies.velocity(body));
    bodies.angular_velocity(body) = solver::without(solver::angular_locks(locks), bodies.angular_velocity(body));
  }
  world.sleeping.awake[body] = world.records.dynamic[body];
  if (type == BodyType::Dynamic) return;
  if constexpr (with_direct_contacts) world.selection.forget(body);
  world.control.forget(body);
}

bool weighs_the_same(const BodyConstants& a, const BodyConstants& b) {
  return a.type == b.type && a.locks == b.locks && a.inverse_mass == b.inverse_mass && a.inertia == b.inertia &&
         a.centre == b.centre;
}

void take_mass_of(const BodyConstants& from, BodyConstants& to) {
  to.centre = from.centre;
  to.inverse_mass = from.inverse_mass;
  to.inertia = from.inertia;
  to.inverse_inertia = from.inverse_inertia;
  to.gyroscopic = from.gyroscopic;
  to.principal_axes = from.principal_axes;
  to.moments = from.moments;
}

void check_joints(const Stores& world, std::uint32_t body, const BodyConstants& constants) {
  if (constants.locks == 0) return;
  world.joints.for_each_of(body, [](std::uint32_t) {
    throw Error("World::set_definition: locks are given to a body with joints; expected none, or no joints");
  });
}

}  // namespace

void redefine(Stores& world, std::uint32_t body, const BodyConstants& constants) {
  solver::BodyTable& bodies = world.bodies;
  wake_touching(world, body);
  if constexpr (with_joints) wake_joined(world, body);
  world.sleeping.wake(body);
  const Vector3 shift = bodies.orientation(body) * (constants.centre - world.records.centre[body]);
  bodies.position(body) += shift;
  bodies.velocity(body) += bodies.angular_velocity(body).cross(shift);
  if (place_of(*world.records.constants[body]) == place_of(constants)) {
    change_constants(world, body, constants);
  } else {
    give_other_place(world, body, constants);
  }
  follow_type(world, body);
  if constexpr (with_joints) move_anchors(world, body);
  world.quarantine.suspect(body);
  note_arrival_or_departure(world, body);
}

BodyConstants redefined(const Stores& world, std::uint32_t body, const BodyDef& def) {
  const BodyConstants& present = *world.records.constants[body];
  BodyDef same = definition_of(world, body);
  same.velocity = same.angular_velocity = Vector3::Zero();
  const BodyConstants before = check(same).constants;
  BodyConstants after = check(def).constants;
  if constexpr (with_joints) check_joints(world, body, after);
  // A definition rounds masses and frames: what it says again keeps its bits.
  if (weighs_the_same(before, after)) take_mass_of(present, after);
  if (place_of(before) == place_of(after)) {
    for (std::size_t i = 0; i < after.colliders.size(); ++i) after.colliders[i].local = present.colliders[i].local;
  }
  if (fingerprint(before) == fingerprint(after)) return present;
  return after;
}

}  // namespace atl
