#include "world/redefine.h"

#include <atoll/error.h>
#include <collision/shapes/height_field.h>
#include <features/with_direct_contacts.h>
#include <features/with_joints.h>
#include <solver/integrate/motion_locks.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <variant>

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
  update_size(world, body);
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
  mark_arrival_or_departure(world, body);
}

BodyConstants redefined(const Stores& world, std::uint32_t body, const BodyDef& def) {
  const BodyConstants& present = *world.records.constants[body];
  BodyDef same = definition_of(world, body);
  same.velocity = same.angular_velocity = Vector3::Zero();
  const BodyConstants before = check(same).constants;
  BodyConstants after = check(def).constants;
  // A definition rounds masses and frames: what it says again keeps its bits.
  if (weighs_the_same(before, after)) take_mass_of(present, after);
  if (place_of(before) == place_of(after)) {
    for (std::size_t i = 0; i < after.colliders.size(); ++i) after.colliders[i].local = present.colliders[i].local;
  }
  if (fingerprint(before) == fingerprint(after)) return present;
  return after;
}

namespace {

// Bounds, in the world, of all triangles of a field that other heights of these samples change, as they are now. The
// normals of a smooth surface and the neighbours of edges reach two samples farther.
collision::Bounds changed_bounds(const Stores& world, std::uint32_t collider, const Samples& samples,
                                 std::size_t rows) {
  const collision::HeightField& field = *world.colliders.shape[collider].field;
  const auto from = [](std::uint32_t first) { return first - std::min(first, 2u); };
  const auto end = [](std::size_t last, std::uint32_t all) { return std::min<std::size_t>(last + 2, all); };
  const std::size_t right = end(std::size_t{samples.column} + samples.columns, field.columns);
  const std::size_t top = end(samples.row + rows, field.rows);
  double lowest = field.highest, highest = field.lowest;
  for (std::size_t row = from(samples.row); row < top; ++row) {
    for (std::size_t column = from(samples.column); column < right; ++column) {
      const double height = field.heights[row * field.columns + column];
      lowest = std::fmin(lowest, height);  // the other one of a hole
      highest = std::fmax(highest, height);
    }
  }
  const Vector3 lower(from(samples.column) * field.spacing_x, from(samples.row) * field.spacing_y, lowest);
  const Vector3 upper((static_cast<double>(right) - 1) * field.spacing_x,
                      (static_cast<double>(top) - 1) * field.spacing_y, highest);
  const collision::Pose pose =
      world.colliders.pose(collider, {world.bodies.positions.data(), world.bodies.orientations.data()});
  return collision::bounds_of_box(lower, upper, pose.position, pose.orientation.toRotationMatrix());
}

// The contacts of a collider that triangles within these bounds may have a part in are computed anew in the next step.
void outdate_contacts(Stores& world, std::uint32_t collider, const collision::Bounds& changed) {
  const collision::BodyMotions now = motions(world);
  world.cache.for_each_contact_of(world.colliders.body[collider], [&](std::uint32_t slot) {
    collision::Contact& contact = world.cache.contacts[slot];
    const std::uint32_t other = contact.pair.first == collider ? contact.pair.second : contact.pair.first;
    const double reach = std::max(contact.gap, contact.margin) + contact.size;
    const collision::Bounds own = now.bounds_now(other);
    if (((own.lower - changed.upper).array() > reach).any() || ((changed.lower - own.upper).array() > reach).any()) {
      return;
    }
    contact.gap = 0;
    contact.set_tolerance(0);
  });
}

void wake_within(Stores& world, const collision::Bounds& bounds) {
  const collision::Aabb box = collision::Aabb::around(bounds.lower, bounds.upper);
  const collision::Proxies& proxies = world.broadphase.proxies();
  for (std::uint32_t collider = 0; collider < world.colliders.shape.size(); ++collider) {
    if (!proxies.contains(collider) || proxies.is_half_space(collider)) continue;
    if (proxies.fat_box(collider).overlaps(box)) world.sleeping.wake(world.colliders.body[collider]);
  }
}

}  // namespace

void change_heights(Stores& world, std::uint32_t body, const Samples& samples, std::span<const double> heights) {
  BodyConstants constants = *world.records.constants[body];
  CheckedCollider& ground = constants.colliders.front();
  if (ground.shape.kind != collision::ShapeKind::HeightField) {
    throw Error("World::set_heights: the body has another shape; expected a HeightField");
  }
  auto made = collision::with_heights(*ground.shape.field, samples.column, samples.row, samples.columns, heights);
  if (const auto* problem = std::get_if<std::string>(&made)) throw Error("World::set_heights: " + *problem);
  const auto field = std::make_shared<const collision::HeightField>(std::get<collision::HeightField>(std::move(made)));
  ground.shape = collision::Shape::height_field(*field);
  ground.geometry = field;
  ground.content = field->content;
  const std::uint32_t collider = world.colliders.first[body];
  const std::size_t rows = heights.size() / samples.columns;
  const collision::Bounds before = changed_bounds(world, collider, samples, rows);
  exchange_constants(world, body, constants);
  update_size(world, body);
  const collision::Bounds after = changed_bounds(world, collider, samples, rows);
  const collision::Bounds both = {before.lower.cwiseMin(after.lower), before.upper.cwiseMax(after.upper)};
  outdate_contacts(world, collider, both);
  wake_within(world, both);
  move_proxies(world, body);
}

}  // namespace atl
