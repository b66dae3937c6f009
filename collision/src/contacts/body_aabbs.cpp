#include <collision/broadphase/fat_box.h>
#include <collision/contacts/body_aabbs.h>
#include <collision/contacts/meeting.h>
#include <collision/contacts/refresh.h>
#include <jobs/assert.h>
#include <jobs/scratch.h>

#include <algorithm>

namespace atl::collision {
namespace {

// Room that a fat AABB leaves beyond what is needed now, as part of the inner radius: 7.5 cm for a cube of 1 m.
constexpr double margin_room = 0.15;

// Part of its inner radius by which a body has to move in a step to be swept. The speculative margin has seen anything
// nearer than half of that radius at the start. So the centres of two bodies that meet head on, each at this speed,
// can't pass each other unseen.
constexpr double sweep_share = 0.75;
// One that asks for it, from this part on: not for what rounding does to a body at rest.
constexpr double always_share = 1e-3;

constexpr std::size_t aabb_grain = 256;  // AABBs that a task looks at, or a body's if it has more

bool is_bounded(const Shape& shape) { return shape.kind != ShapeKind::HalfSpace; }

// The size (m) that a collider's tolerances are parts of. A surface has no inner radius; it doesn't move freely either.
double size_of(const Shape& shape) {
  return shape.inner_radius < infinity ? shape.inner_radius : 0.01 * shape.bounding_radius;
}

Vector3 row(const double* rows, std::uint32_t body) { return Eigen::Map<const Vector3>(rows + 3 * body); }

// The bounds of two together.
Bounds around(const Bounds& a, const Bounds& b) { return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)}; }

// The pose of a body after some time (s) at its speed.
Pose pose_after(double time, const Pose& pose, const Vector3& velocity, const Vector3& spin) {
  const Vector3 half = 0.5 * time * spin;
  const Quaternion turn = Quaternion(1, half.x(), half.y(), half.z()).normalized();
  return {pose.position + time * velocity, turn * pose.orientation};
}

// The distance by which bounds may grow on every side and stay in a box. Negative if they are not in it.
double room_in(const Aabb& box, const Bounds& bounds) {
  double room = infinity;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    room = std::min({room, static_cast<double>(box.upper[i]) - bounds.upper[axis],
                     bounds.lower[axis] - static_cast<double>(box.lower[i])});
  }
  return room;
}

// Bodies with that many AABBs, by the mean of all.
std::size_t bodies_a_task(std::size_t bodies, std::size_t colliders) {
  return std::max(std::size_t{1}, aabb_grain * bodies / std::max({std::size_t{1}, colliders, bodies}));
}

// True if all shapes of a body are in their fat AABBs.
bool is_inside(std::uint32_t body, const BodyMotions& motions, const Broadphase& broadphase) {
  const ColliderTable& colliders = motions.colliders;
  bool inside = motions.is_finite(body);
  colliders.for_each_of(body, [&](std::uint32_t collider) {
    if (!inside) return;
    inside = is_bounded(colliders.shape[collider]);
    if (!inside) return;
    // The ball around it is there for less than its box.
    const Aabb& fat = broadphase.proxies().fat_box(collider);
    const Vector3 centre =
        motions.poses[body].position + motions.poses[body].orientation * colliders.local[collider].position;
    const Vector3 around = Vector3::Constant(colliders.shape[collider].bounding_radius);
    const double rounding = 1e-12 * (centre.lpNorm<1>() + around.x());
    inside =
        room_in(fat, {centre - around, centre + around}) >= rounding || room_in(fat, motions.bounds_now(collider)) >= 0;
  });
  return inside;
}

}  // namespace

Bounds BodyMotions::bounds_at(std::uint32_t collider, const Pose& pose) const {
  return bounds_of(colliders.shape[collider], pose.position, pose.orientation.toRotationMatrix());
}

Plane BodyMotions::plane_now(std::uint32_t half_space) const {
  const Shape& shape = colliders.shape[half_space];
  const Pose pose = colliders.pose(half_space, poses);
  const Vector3 normal = pose.orientation * shape.normal;
  return {normal, shape.offset + normal.dot(pose.position)};
}

bool BodyMotions::is_finite(std::uint32_t body) const {
  const Pose pose = poses[body];
  return pose.position.allFinite() && pose.orientation.coeffs().allFinite();
}

void BodyAabbs::resize(std::size_t bodies) {
  bounds.resize(bodies);
  jobs::append(swept_margins_, bodies, 0.0);
}

void BodyAabbs::clear() {
  bounds = {};
  swept_margins_.clear();
  swept_.clear();
}

void BodyAabbs::list_swept() {
  swept_.clear();
  for (std::uint32_t body = 0; body < swept_margins_.size(); ++body) {
    if (swept_margins_[body] > 0) swept_.push_back(body);
  }
}

double BodyAabbs::set_limits(std::uint32_t body, Sweep sweep, const BodyMotions& motions) {
  const ColliderTable& colliders = motions.colliders;
  double radius = 0;
  double size = infinity;
  colliders.for_each_of(body, [&](std::uint32_t collider) {
    const Shape& shape = colliders.shape[collider];
    if (!is_bounded(shape)) {
      radius = std::max(radius, 1.0);  // of any length: the margin is 0, so that any turn is a motion beyond it
      return;
    }
    radius = std::max(radius, colliders.local[collider].position.norm() + shape.bounding_radius);
    size = std::min(size, size_of(shape));
  });
  bounds.margin_limit[body] = approach_share * size;
  bounds.sweep_distance[body] = sweep == Sweep::Never    ? infinity
                                : sweep == Sweep::Always ? always_share * size
                                                         : sweep_share * size;
  return radius;
}

void BodyAabbs::add(std::uint32_t body, bool fixed, const Filter& filter, const BodyMotions& motions,
                    Broadphase& broadphase) {
  bounds.aabb_margin[body] = infinity;
  ATL_ASSERT(body < swept_margins_.size() && bounds.aabb_margin.size() == swept_margins_.size(), body,
             bounds.aabb_margin.size(), swept_margins_.size());
  swept_margins_[body] = 0;
  // The body's speed is not yet in its AABB, since only a step says how long it is.
  bounds.aabb_dirty[body] = 1;
  motions.colliders.for_each_of(body, [&](std::uint32_t collider) {
    if (is_bounded(motions.colliders.shape[collider])) {
      const Update update = look_at(collider, nullptr, motions);
      broadphase.add_box(collider, update.fat, fixed, filter);
      bounds.aabb_margin[body] = std::min(bounds.aabb_margin[body], update.margin);
    } else {
      broadphase.add_half_space(collider, motions.plane_now(collider), filter);
      bounds.aabb_margin[body] = 0;
    }
  });
  add_swept(body, motions);
}

void BodyAabbs::remove(std::uint32_t body, const ColliderTable& colliders, Broadphase& broadphase) {
  colliders.for_each_of(body, [&](std::uint32_t collider) { broadphase.remove(collider); });
}

void BodyAabbs::move(std::uint32_t body, const BodyMotions& motions, Broadphase& broadphase) {
  if (!motions.is_finite(body)) return;
  bounds.aabb_margin[body] = infinity;
  motions.colliders.for_each_of(body, [&](std::uint32_t collider) {
    if (is_bounded(motions.colliders.shape[collider])) {
      const Update update = look_at(collider, nullptr, motions);
      broadphase.move_box(collider, update.fat);
      bounds.aabb_margin[body] = std::min(bounds.aabb_margin[body], update.margin);
    } else {
      broadphase.move_half_space(collider, motions.plane_now(collider));
      bounds.aabb_margin[body] = 0;
    }
  });
  add_swept(body, motions);
}

void BodyAabbs::mark_all_dirty() { std::fill(bounds.aabb_dirty.begin(), bounds.aabb_dirty.end(), std::uint8_t{1}); }

// Checks the fat AABB of a collider, and makes a new one if the current one is too small. It must hold the bounds,
// grown by the speculative margin and by how far the body may move in a step. For a body faster than that margin
// covers, it must hold the bounds after the step too. A new one gets some room beyond, so that it isn't outgrown again
// at once.
BodyAabbs::Update BodyAabbs::look_at(std::uint32_t collider, const Aabb* current, const BodyMotions& motions) const {
  const ColliderTable& colliders = motions.colliders;
  const std::uint32_t body = colliders.body[collider];
  const Vector3 velocity = row(motions.velocities, body);
  const Vector3 spin = row(motions.angular_velocities, body);
  const Bounds now = motions.bounds_now(collider);
  const double size = size_of(colliders.shape[collider]);
  ATL_ASSERT(size > 0 && size < infinity, collider, body, size);
  ATL_ASSERT(motions.dt >= 0, motions.dt);
  const double reach = (velocity.norm() + spin.norm() * motions.radius[body]) * motions.dt;
  // The shift (m) of the shape's own origin, since a compound's child also moves when its body turns.
  Vector3 shift = motions.dt * velocity;
  if (colliders.has_local_offset[collider]) {
    const Vector3 arm = motions.poses[body].orientation * colliders.local[collider].position;
    shift += motions.dt * spin.cross(arm);
  }
  const double still = speculative_margin(size, 0);
  const double needed = speculative_margin(size, reach);

  const double room = current ? room_in(*current, now) : -1;
  const bool is_fast = reach > bounds.margin_limit[body];
  // The box reaches as far ahead as contacts do, or nothing would find the pair that is to meet.
  const Bounds then =
      is_fast
          ? around(now, motions.bounds_at(
                            collider, placed(pose_after(steps_ahead * motions.dt, motions.poses[body], velocity, spin),
                                             colliders.local[collider])))
          : now;
  if (current != nullptr && room >= needed && (!is_fast || room_in(*current, then) >= still)) {
    return {*current, room - still, false};
  }
  const double margin = needed + margin_room * size;
  const Aabb fat = fattened(now, margin, shift);
  if (!is_fast) return {fat, margin - still, true};
  const Vector3 more = Vector3::Constant(margin);
  return {fat.joined(Aabb::around(then.lower - more, then.upper + more)), margin - still, true};
}

double BodyAabbs::swept_margin(std::uint32_t body, const BodyMotions& motions) const {
  const double swept = predicted_steps * motions.dt * row(motions.velocities, body).norm();
  return swept > margin_room / approach_share * bounds.margin_limit[body] ? swept : 0;
}

void BodyAabbs::add_swept(std::uint32_t body, const BodyMotions& motions) {
  ATL_ASSERT(swept_margins_[body] >= 0, body, swept_margins_[body]);
  const double swept = swept_margin(body, motions);
  if (swept > 0 && swept_margins_[body] == 0) swept_.push_back(body);
  swept_margins_[body] = std::max(swept, swept_margins_[body]);
}

// AABBs that were stretched along a motion which has slowed down since are made anew, or a body that comes to rest
// would have pairs with all that lies where it was going.
void BodyAabbs::shrink_swept(const BodyMotions& motions, Broadphase& broadphase) {
  jobs::erase_if(swept_, [&](std::uint32_t body) {
    const bool is_there = motions.colliders.first[body] != ColliderTable::none;
    if (swept_margins_[body] > 0 && is_there && motions.is_finite(body)) {
      const double now = swept_margin(body, motions);
      if (now > 0.5 * swept_margins_[body]) return false;
      move(body, motions, broadphase);
      swept_margins_[body] = now;
      if (now > 0) return false;
    }
    swept_margins_[body] = 0;
    return true;
  });
}

void BodyAabbs::update(std::span<const std::uint32_t> active, const BodyMotions& motions, Broadphase& broadphase,
                       jobs::Arena& arena) {
  shrink_swept(motions, broadphase);
  const jobs::Borrowed<Memory> memory;
  std::vector<std::uint32_t>& dirty = memory->dirty;
  std::vector<std::vector<Update>>& updates_of = memory->updates;
  dirty.clear();
  for (const std::uint32_t body : active) {
    if (bounds.aabb_dirty[body]) dirty.push_back(body);
  }
  if (dirty.empty()) return;
  const ColliderTable& colliders = motions.colliders;
  const std::size_t grain = bodies_a_task(swept_margins_.size(), colliders.size());
  const std::size_t chunks = jobs::Arena::chunk_count(dirty.size(), grain);
  if (updates_of.size() < chunks) updates_of.resize(chunks);
  arena.parallel_for(dirty.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<Update>& updates = updates_of[begin / grain];
    updates.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t body = dirty[i];
      if (!motions.is_finite(body)) continue;
      bounds.aabb_dirty[body] = 0;
      bounds.aabb_margin[body] = infinity;
      colliders.for_each_of(body, [&](std::uint32_t collider) {
        double margin = 0;
        if (is_bounded(colliders.shape[collider])) {
          updates.push_back(look_at(collider, &broadphase.proxies().fat_box(collider), motions));
          margin = updates.back().margin;
        }
        bounds.aabb_margin[body] = std::min(bounds.aabb_margin[body], margin);
      });
    }
  });
  const Update* next = nullptr;
  for (std::size_t i = 0; i < dirty.size(); ++i) {
    if (i % grain == 0) next = updates_of[i / grain].data();
    const std::uint32_t body = dirty[i];
    if (!motions.is_finite(body)) continue;
    bool any_new = false;
    colliders.for_each_of(body, [&](std::uint32_t collider) {
      if (!is_bounded(colliders.shape[collider])) {
        broadphase.move_half_space(collider, motions.plane_now(collider));
        return;
      }
      ATL_ASSERT(next < updates_of[i / grain].data() + updates_of[i / grain].size(), body, collider, i);
      const Update& update = *next++;
      if (!update.is_new) return;
      broadphase.move_box(collider, update.fat);
      any_new = true;
    });
    if (any_new) add_swept(body, motions);
  }
}

// Margins don't know along which way an AABB is stretched, so they tell only who may be out.
void BodyAabbs::catch_up(std::span<const std::uint32_t> active, const BodyMotions& motions, Broadphase& broadphase,
                         jobs::Arena& arena) {
  const jobs::Borrowed<Memory> memory;
  std::vector<std::uint32_t>& dirty = memory->dirty;
  std::vector<std::uint8_t>& inside = memory->inside;
  dirty.clear();
  for (const std::uint32_t body : active) {
    if (bounds.aabb_dirty[body] && !(bounds.aabb_margin[body] >= 0)) dirty.push_back(body);
  }
  if (dirty.empty()) return;
  inside.resize(dirty.size());
  const std::size_t grain = bodies_a_task(swept_margins_.size(), motions.colliders.size());
  arena.parallel_for(dirty.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) inside[i] = is_inside(dirty[i], motions, broadphase);
  });
  for (std::size_t i = 0; i < dirty.size(); ++i) {
    if (!inside[i]) move(dirty[i], motions, broadphase);
  }
}

}  // namespace atl::collision
