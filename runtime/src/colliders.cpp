// Bodies' shapes, and their boxes in the broadphase.

#include <collision/broadphase/fat_box.h>
#include <collision/narrowphase/surface_contacts.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "body_definition.h"
#include "world_impl.h"

namespace atl {
namespace {

// Room that a fat box leaves beyond what is needed now, as part of the inner radius: 7.5 cm for a cube of 1 m.
constexpr double slack_share = 0.15;

// A body that moves farther than this part of its inner radius in a step is swept. What is nearer than half of that
// radius at the start has been seen by the speculative margin, so of two bodies that meet head on, at this speed
// each, the centres can't pass each other unseen.
constexpr double sweep_share = 0.75;
// One that asks for it, from this part on: not for what rounding does to a body at rest.
constexpr double continuous_share = 1e-3;

using collision::infinity;

bool is_bounded(const collision::Shape& shape) { return shape.kind != collision::ShapeKind::HalfSpace; }

// What tolerances of a collider are parts of. A surface has no size of its own, and doesn't move freely.
double size_of(const collision::Shape& shape) {
  return shape.inner_radius < infinity ? shape.inner_radius : 0.01 * shape.bounding_radius;
}

constexpr std::size_t box_grain = 256;  // boxes that a task looks at, or a body's if it has more

// How far bounds may grow on every side before they leave a box.
double room_in(const collision::Aabb& box, const collision::Bounds& bounds) {
  double room = infinity;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    room = std::min({room, static_cast<double>(box.upper[i]) - bounds.upper[axis],
                     bounds.lower[axis] - static_cast<double>(box.lower[i])});
  }
  return room;
}

collision::Bounds ahead_of(const collision::Bounds& bounds, const Vector3& shift) {
  return {bounds.lower + shift, bounds.upper + shift};
}

}  // namespace

void World::Impl::add_colliders(std::uint32_t body) {
  const BodyConstants& constants = *records.constants[body];
  std::uint32_t previous = collision::ColliderTable::none;
  std::uint32_t child = 0;
  for (const CheckedCollider& part : constants.colliders) {
    const std::uint32_t collider = colliders.add(body, child++, part.shape, part.in_frame_of(constants.centre));
    (previous == collision::ColliderTable::none ? records.first_collider[body] : colliders.next[previous]) = collider;
    previous = collider;
  }
}

// How far the shapes reach, and what that makes of its motion.
void World::Impl::note_size(std::uint32_t body) {
  const BodyConstants& constants = *records.constants[body];
  double radius = 0;
  double size = infinity;
  for (const CheckedCollider& part : constants.colliders) {
    if (!is_bounded(part.shape)) continue;
    radius = std::max(radius, part.in_frame_of(constants.centre).position.norm() + part.shape.bounding_radius);
    size = std::min(size, size_of(part.shape));
  }
  bodies.radius[body] = radius;
  bodies.reach_limit[body] = collision::approach_share * size;
  // Only dynamic bodies are stopped by what they hit; how kinematic ones move is part of what these meet.
  bodies.sweep_distance[body] = constants.type == BodyType::Static ? infinity
                                : constants.continuous             ? continuous_share * size
                                                                   : sweep_share * size;
}

// Puts all colliders of a body into the broadphase.
void World::Impl::add_proxies(std::uint32_t body, const collision::Filter& filter) {
  bodies.slack[body] = infinity;
  stretch_[body] = 0;
  // Its speed has not been accounted for: how long a step is shows when there is one.
  bodies.outgrown[body] = 1;
  for_each_collider(body, [&](std::uint32_t collider) {
    if (is_bounded(colliders.shape[collider])) {
      const ProxyBox box = proxy_box(collider, nullptr);
      add_box(collider, box.fat, filter);
      bodies.slack[body] = std::min(bodies.slack[body], box.slack);
    } else {
      broadphase.add_half_space(collider, world_plane(collider), filter);
      bodies.slack[body] = 0;
    }
  });
  note_stretch(body);
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

void World::Impl::remove_proxies(std::uint32_t body) {
  for_each_collider(body, [this](std::uint32_t collider) { broadphase.remove(collider); });
}

// Of a body that has no proxies any more.
void World::Impl::remove_colliders(std::uint32_t body) {
  for (std::uint32_t c = records.first_collider[body]; c != collision::ColliderTable::none;) {
    const std::uint32_t next = colliders.next[c];
    colliders.remove(c);
    c = next;
  }
  records.first_collider[body] = collision::ColliderTable::none;
  if (const auto found = records.ignored.find(body); found != records.ignored.end()) {
    for (const std::uint32_t other : found->second) {
      broadphase.unignore(body, other);
      std::erase(records.ignored[other], body);
    }
    records.ignored.erase(body);
  }
}

collision::Bounds World::Impl::bounds_at(std::uint32_t collider, const collision::Pose& pose) const {
  return collision::bounds_of(colliders.shape[collider], pose.position, pose.orientation.toRotationMatrix());
}

collision::Bounds World::Impl::bounds_now(std::uint32_t collider) const {
  return bounds_at(collider, colliders.pose(collider, {bodies.positions.data(), bodies.orientations.data()}));
}

// What must fit into a fat box: the bounds, grown by the speculative margin and where the body may get to in a
// step; of one that is faster than margins see, where they will be after it, too. A new fat box has some room beyond,
// so that it needn't be asked again at once.
World::Impl::ProxyBox World::Impl::proxy_box(std::uint32_t collider, const collision::Aabb* current) const {
  const std::uint32_t body = colliders.body[collider];
  const collision::Bounds bounds = bounds_now(collider);
  const double size = size_of(colliders.shape[collider]);
  const double reach =
      (bodies.velocity(body).norm() + bodies.angular_velocity(body).norm() * bodies.radius[body]) * dt_;
  // Of the shape's own origin: that of a compound's child moves as its body turns, too.
  Vector3 shift = dt_ * bodies.velocity(body);
  if (colliders.placed[collider]) {
    const Vector3 arm = bodies.orientation(body) * colliders.local[collider].position;
    shift += dt_ * bodies.angular_velocity(body).cross(arm);
  }
  const double still = collision::speculative_margin(size, 0);
  const double needed = collision::speculative_margin(size, reach);

  const double room = current ? room_in(*current, bounds) : -1;
  const bool is_fast = reach > bodies.reach_limit[body];
  if (room >= needed && (!is_fast || room_in(*current, ahead_of(bounds, shift)) >= still)) {
    return {*current, room - still, false};
  }
  const double slack = needed + slack_share * size;
  return {collision::fattened(bounds, slack, shift), slack - still, true};
}

collision::Plane World::Impl::world_plane(std::uint32_t collider) const {
  const collision::Shape& shape = colliders.shape[collider];
  const collision::Pose pose = colliders.pose(collider, {bodies.positions.data(), bodies.orientations.data()});
  const Vector3 normal = pose.orientation * shape.normal;
  return {normal, shape.offset + normal.dot(pose.position)};
}

// A body was put elsewhere, or got out of its boxes.
void World::Impl::move_proxies(std::uint32_t body) {
  if (!is_finite(body) || quarantine.contains(body)) return;
  bodies.slack[body] = infinity;
  for_each_collider(body, [&](std::uint32_t collider) {
    if (is_bounded(colliders.shape[collider])) {
      const ProxyBox box = proxy_box(collider, nullptr);
      broadphase.move_box(collider, box.fat);
      bodies.slack[body] = std::min(bodies.slack[body], box.slack);
    } else {
      broadphase.move_half_space(collider, world_plane(collider));
      bodies.slack[body] = 0;
    }
  });
  note_stretch(body);
}

// Bodies with that many boxes, by the mean of all.
std::size_t World::Impl::bodies_a_task() const {
  return std::max(std::size_t{1},
                  box_grain * bodies.size() / std::max({std::size_t{1}, colliders.size(), bodies.size()}));
}

bool World::Impl::is_in_boxes(std::uint32_t body) const {
  bool inside = is_finite(body);
  const collision::PoseView poses{bodies.positions.data(), bodies.orientations.data()};
  for_each_collider(body, [&](std::uint32_t collider) {
    if (!inside) return;
    inside = is_bounded(colliders.shape[collider]);
    if (!inside) return;
    // The ball around it is there for less than its box.
    const collision::Aabb& fat = broadphase.fat_box(collider);
    const Vector3 centre = poses[body].position + poses[body].orientation * colliders.local[collider].position;
    const Vector3 around = Vector3::Constant(colliders.shape[collider].bounding_radius);
    const double rounding = 1e-12 * (centre.lpNorm<1>() + around.x());
    inside = room_in(fat, {centre - around, centre + around}) >= rounding || room_in(fat, bounds_now(collider)) >= 0;
  });
  return inside;
}

// A body that was pushed along farther than its speed had let expect is out of its boxes already: queries between
// steps go by them. Slack doesn't know along which way a box is stretched, so it tells only who may be out.
void World::Impl::catch_up_boxes() {
  looked_at_.clear();
  for (const std::uint32_t body : active_.in_order()) {
    if (bodies.outgrown[body] && !(bodies.slack[body] >= 0)) looked_at_.push_back(body);
  }
  in_boxes_.resize(looked_at_.size());
  arena.parallel_for(looked_at_.size(), bodies_a_task(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) in_boxes_[i] = is_in_boxes(looked_at_[i]);
  });
  for (std::size_t i = 0; i < looked_at_.size(); ++i) {
    if (!in_boxes_[i]) move_proxies(looked_at_[i]);
  }
}

void World::Impl::note_stretch(std::uint32_t body) {
  const double stretch = stretch_of(body);
  if (stretch > 0 && stretch_[body] == 0) stretched_.push_back(body);
  stretch_[body] = std::max(stretch, stretch_[body]);
}

// How far a body's fat boxes are stretched along its motion, where that is worth mentioning.
double World::Impl::stretch_of(std::uint32_t body) const {
  const double stretch = collision::predicted_steps * dt_ * bodies.velocity(body).norm();
  return stretch > slack_share / collision::approach_share * bodies.reach_limit[body] ? stretch : 0;
}

// Boxes that were stretched along a motion which has slowed down since are made anew, or a body that comes to rest
// would have pairs with all that lies where it was going.
void World::Impl::shrink_boxes() {
  std::erase_if(stretched_, [this](std::uint32_t body) {
    if (stretch_[body] > 0 && records.alive[body] && is_finite(body)) {
      const double now = stretch_of(body);
      if (now > 0.5 * stretch_[body]) return false;
      move_proxies(body);
      stretch_[body] = now;
      if (now > 0) return false;
    }
    stretch_[body] = 0;
    return true;
  });
}

// Only bodies that may have used up the slack of their boxes are looked at: the cost follows motion.
void World::Impl::find_pairs() {
  // A longer step reaches farther than was accounted for.
  if (dt_ > last_dt_) std::fill(bodies.outgrown.begin(), bodies.outgrown.end(), std::uint8_t{1});
  shrink_boxes();
  looked_at_.clear();
  for (const std::uint32_t body : active_.in_order()) {
    if (bodies.outgrown[body]) looked_at_.push_back(body);
  }
  const std::size_t grain = bodies_a_task();
  const std::size_t chunks = jobs::Arena::chunk_count(looked_at_.size(), grain);
  if (new_boxes_.size() < chunks) new_boxes_.resize(chunks);
  arena.parallel_for(looked_at_.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<ProxyBox>& new_boxes = new_boxes_[begin / grain];
    new_boxes.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t body = looked_at_[i];
      if (!is_finite(body)) continue;
      bodies.outgrown[body] = 0;
      bodies.slack[body] = infinity;
      for_each_collider(body, [&](std::uint32_t collider) {
        double slack = 0;
        if (is_bounded(colliders.shape[collider])) {
          new_boxes.push_back(proxy_box(collider, &broadphase.fat_box(collider)));
          slack = new_boxes.back().slack;
        }
        bodies.slack[body] = std::min(bodies.slack[body], slack);
      });
    }
  });
  const ProxyBox* next_box = nullptr;
  for (std::size_t i = 0; i < looked_at_.size(); ++i) {
    if (i % grain == 0) next_box = new_boxes_[i / grain].data();
    const std::uint32_t body = looked_at_[i];
    if (!is_finite(body)) continue;
    bool outgrown = false;
    for_each_collider(body, [&](std::uint32_t collider) {
      if (!is_bounded(colliders.shape[collider])) {
        broadphase.move_half_space(collider, world_plane(collider));
        return;
      }
      const ProxyBox& box = *next_box++;
      if (!box.outgrown) return;
      broadphase.move_box(collider, box.fat);
      outgrown = true;
    });
    if (outgrown) note_stretch(body);
  }
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
