// Bodies' shapes, and their boxes in the broadphase.

#include <collision/narrowphase/surface_contacts.h>

#include <algorithm>
#include <cmath>

#include "world/body_definition.h"
#include "world/world_impl.h"

namespace atl {
void World::Impl::add_colliders(std::uint32_t body) {
  const BodyConstants& constants = *records.constants[body];
  std::uint32_t previous = collision::ColliderTable::none;
  std::uint32_t child = 0;
  for (const CheckedCollider& part : constants.colliders) {
    const std::uint32_t collider = colliders.add(body, child++, part.shape, part.in_frame_of(constants.centre));
    (previous == collision::ColliderTable::none ? colliders.first[body] : colliders.next[previous]) = collider;
    previous = collider;
  }
}

collision::BodyMotions World::Impl::motions() const {
  return {.colliders = colliders,
          .poses = {bodies.positions.data(), bodies.orientations.data()},
          .velocities = bodies.velocities.data(),
          .angular_velocities = bodies.angular_velocities.data(),
          .radius = bodies.radius,
          .dt = dt_};
}

// How far the shapes of a new body reach, and what that makes of its motion. Only dynamic bodies are stopped by what
// they hit; how kinematic ones move is part of what these meet.
void World::Impl::note_size(std::uint32_t body) {
  using Sweep = collision::BodyAabbs::Sweep;
  const Sweep sweep = records.type[body] == BodyType::Static ? Sweep::Never
                      : records.continuous[body]             ? Sweep::Always
                                                             : Sweep::IfFast;
  bodies.radius[body] = aabbs.set_limits(body, sweep, motions());
}

// Puts all colliders of a body into the broadphase.
void World::Impl::add_proxies(std::uint32_t body, const collision::Filter& filter) {
  const bool fixed = records.type[body] == BodyType::Static;
  aabbs.add(body, fixed, filter, motions(), broadphase);
  if (fixed) boxes_wait_.store(true, std::memory_order_relaxed);
}

void World::Impl::add_box(std::uint32_t collider, const collision::Aabb& box, const collision::Filter& filter) {
  const bool fixed = records.type[colliders.body[collider]] == BodyType::Static;
  broadphase.add_box(collider, box, fixed, filter);
  if (fixed) boxes_wait_.store(true, std::memory_order_relaxed);
}

// Before queries.
void World::Impl::take_in_boxes() {
  if (!boxes_wait_.load(std::memory_order_acquire)) return;
  const std::lock_guard lock(taking_in_);
  if (!boxes_wait_.load(std::memory_order_relaxed)) return;
  broadphase.take_in(arena);
  boxes_wait_.store(false, std::memory_order_release);
}

// Of a body that has no proxies any more.
void World::Impl::remove_colliders(std::uint32_t body) {
  for (std::uint32_t c = colliders.first[body]; c != collision::ColliderTable::none;) {
    const std::uint32_t next = colliders.next[c];
    colliders.remove(c);
    c = next;
  }
  colliders.first[body] = collision::ColliderTable::none;
  if (const auto found = records.ignored.find(body); found != records.ignored.end()) {
    for (const std::uint32_t other : found->second) {
      broadphase.unignore(body, other);
      std::erase(records.ignored[other], body);
    }
    records.ignored.erase(body);
  }
}

// A body was put elsewhere, or left its AABBs.
void World::Impl::move_proxies(std::uint32_t body) {
  if (!quarantine.contains(body)) aabbs.move(body, motions(), broadphase);
}

void World::Impl::find_pairs() {
  // A longer step reaches farther than was accounted for.
  if (dt_ > last_dt_) aabbs.mark_all_dirty();
  aabbs.update(active_.in_order(), motions(), broadphase, arena);
  report_.counts.new_boxes = static_cast<std::int64_t>(broadphase.moved_count());
  cache.add(broadphase.find_new_pairs(cache.pairs, arena),
            [this](collision::Pair pair) { return contact_start(pair); });
}

collision::ContactCache::Start World::Impl::contact_start(collision::Pair pair) const {
  const std::uint32_t first = colliders.body[pair.first];
  const std::uint32_t second = colliders.body[pair.second];
  const Material& a = records.material[first];
  const Material& b = records.material[second];
  const collision::Shape& shape_first = colliders.shape[pair.first];
  const collision::Shape& shape_second = colliders.shape[pair.second];
  const bool surface = collision::is_surface(shape_first.kind) || collision::is_surface(shape_second.kind);
  return {.body_first = first,
          .body_second = second,
          .friction = static_cast<float>(std::sqrt(a.friction * b.friction)),
          .restitution = static_cast<float>(std::max(a.restitution, b.restitution)),
          .size = static_cast<float>(std::min(shape_first.inner_radius, shape_second.inner_radius)),
          .placed = colliders.placed[pair.first] != 0 || colliders.placed[pair.second] != 0,
          .parts = surface ? collision::max_surface_manifolds : 1};
}

}  // namespace atl
