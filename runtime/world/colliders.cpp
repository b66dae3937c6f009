#include "world/colliders.h"

#include <collision/narrowphase/surface_contacts.h>
#include <jobs/assert.h>

#include <algorithm>
#include <limits>

#include "world/materials.h"

namespace atl {

void add_colliders(Stores& world, std::uint32_t body) {
  const BodyConstants& constants = *world.records.constants[body];
  std::uint32_t previous = collision::ColliderTable::none;
  std::uint32_t child = 0;
  for (const CheckedCollider& part : constants.colliders) {
    const collision::PlacedShape placed = part.in_frame_of(constants.centre);
    const std::uint32_t collider = world.colliders.add(body, child++, placed.shape, placed.pose);
    (previous == collision::ColliderTable::none ? world.colliders.first[body] : world.colliders.next[previous]) =
        collider;
    previous = collider;
  }
}

collision::BodyMotions motions(const Stores& world) {
  return {.colliders = world.colliders,
          .poses = {world.bodies.positions.data(), world.bodies.orientations.data()},
          .velocities = world.bodies.velocities.data(),
          .angular_velocities = world.bodies.angular_velocities.data(),
          .radius = world.bodies.radius,
          .dt = world.clock.dt};
}

void update_size(Stores& world, std::uint32_t body) {
  using Sweep = collision::BodyAabbs::Sweep;
  const Sweep sweep = world.records.type[body] == BodyType::Static ? Sweep::Never
                      : world.records.continuous[body]             ? Sweep::Always
                                                                   : Sweep::IfFast;
  world.bodies.radius[body] = world.aabbs.set_limits(body, sweep, motions(world));
}

const Material& material_of(const Stores& world, std::uint32_t collider, std::uint8_t number) {
  const std::uint32_t body = world.colliders.body[collider];
  ATL_ASSERT(body != collision::ColliderTable::none, collider);
  if (world.contents.own_materials > 0) {
    const BodyConstants& constants = *world.records.constants[body];
    const bool has_numbers = number > 0 && collision::is_surface(world.colliders.shape[collider].kind);
    if (has_numbers && number <= constants.materials.size()) return constants.materials[number - 1u];
    const CheckedCollider& part = constants.colliders[world.colliders.child[collider]];
    if (part.material) return *part.material;
  }
  return world.records.material[body];
}

collision::Filter filter_of(const Stores& world, std::uint32_t collider) {
  const std::uint32_t body = world.colliders.body[collider];
  if (world.records.sensor[body]) return {.category = 0, .mask = 0, .owner = body};
  return own_filter_of(world, collider);
}

collision::Filter own_filter_of(const Stores& world, std::uint32_t collider) {
  const std::uint32_t body = world.colliders.body[collider];
  const CheckedCollider& part = world.records.constants[body]->colliders[world.colliders.child[collider]];
  const CollisionFilter& filter = part.filter ? *part.filter : world.records.filter[body];
  return {filter.category, filter.mask, filter.group, body};
}

BoundingBox bounds_of(const Stores& world, std::uint32_t body) {
  const Vector3 infinity = Vector3::Constant(std::numeric_limits<double>::infinity());
  BoundingBox all{infinity, -infinity};
  world.colliders.for_each_of(body, [&](std::uint32_t collider) {
    const collision::Shape& shape = world.colliders.shape[collider];
    if (shape.kind == collision::ShapeKind::HalfSpace) {
      all = {-infinity, infinity};
      return;
    }
    const collision::Pose pose =
        world.colliders.pose(collider, {world.bodies.positions.data(), world.bodies.orientations.data()});
    const collision::Bounds own = collision::bounds_of(shape, pose.position, pose.orientation.toRotationMatrix());
    all = {all.lower.cwiseMin(own.lower), all.upper.cwiseMax(own.upper)};
  });
  return all;
}

void add_proxies(Stores& world, std::uint32_t body) {
  const bool fixed = world.records.type[body] == BodyType::Static;
  world.aabbs.add(body, fixed, filter_of(world, world.colliders.first[body]), motions(world), world.broadphase);
  if (!has_own_filters(*world.records.constants[body])) return;
  world.colliders.for_each_of(
      body, [&](std::uint32_t collider) { world.broadphase.set_filter(collider, filter_of(world, collider)); });
}

void add_box(Stores& world, std::uint32_t collider, const collision::Aabb& box) {
  const bool fixed = world.records.type[world.colliders.body[collider]] == BodyType::Static;
  world.broadphase.add_box(collider, box, fixed, filter_of(world, collider));
}

void clear_colliders(Stores& world, std::uint32_t body) {
  for (std::uint32_t c = world.colliders.first[body]; c != collision::ColliderTable::none;) {
    const std::uint32_t next = world.colliders.next[c];
    world.colliders.remove(c);
    c = next;
  }
  world.colliders.first[body] = collision::ColliderTable::none;
}

void remove_colliders(Stores& world, std::uint32_t body) {
  clear_colliders(world, body);
  if (const auto found = world.records.disabled_pairs.find(body); found != world.records.disabled_pairs.end()) {
    const std::vector<std::uint32_t> others = found->second;
    for (const std::uint32_t other : others) {
      world.broadphase.enable_pair(body, other);
      world.records.enable_pair(body, other);
    }
  }
}

void move_proxies(Stores& world, std::uint32_t body) {
  if (!world.quarantine.contains(body)) world.aabbs.move(body, motions(world), world.broadphase);
}

collision::ContactCache::Start contact_start(const Stores& world, collision::Pair pair, std::uint8_t material) {
  const std::uint32_t first = world.colliders.body[pair.first];
  const std::uint32_t second = world.colliders.body[pair.second];
  ATL_ASSERT(first != second, pair.first, pair.second, first);
  const Material& a = material_of(world, pair.first, material);
  const Material& b = material_of(world, pair.second, material);
  const collision::Shape& shape_first = world.colliders.shape[pair.first];
  const collision::Shape& shape_second = world.colliders.shape[pair.second];
  const bool surface = collision::is_surface(shape_first.kind) || collision::is_surface(shape_second.kind);
  return {.body_first = first,
          .body_second = second,
          .friction = static_cast<float>(friction_of(world, a, b) + 0.0),  // -0 is 0
          .restitution = static_cast<float>(restitution_of(world, a, b)),
          .size = static_cast<float>(std::min(shape_first.inner_radius, shape_second.inner_radius)),
          .has_local_offset =
              world.colliders.has_local_offset[pair.first] != 0 || world.colliders.has_local_offset[pair.second] != 0,
          .parts = surface ? collision::max_surface_manifolds : 1};
}

void mix_materials(Stores& world, std::uint32_t slot) {
  const collision::Contact& contact = world.cache.contacts[slot];
  const collision::ContactCache::Start start = contact_start(world, contact.pair, contact.material);
  world.cache.manifolds[slot].friction = start.friction;
  world.cache.manifolds[slot].restitution = start.restitution;
}

}  // namespace atl
