// Continuous collision: bodies that moved far in a step are put back to where they first met something in their
// way, so that the next step finds the contact. They keep their velocity. Only these bodies cost anything.

#include <collision/convex.h>
#include <collision/distance.h>
#include <collision/sweep.h>
#include <jobs/with_joints.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include "world_impl.h"

namespace atl {
namespace {

using collision::Motion;
using collision::ShapeKind;

// How near a body is put to what it met, as part of its inner radius: well within the margin in which a contact
// has points.
constexpr double stop_share = 0.25 * static_cast<double>(collision::margin_share);

// What is touched already is left to its contact, unless the core gets to it: the shape with this part of its
// inner radius taken off.
constexpr double core_share = 0.5;

struct Core {
  collision::Shape shape;
  Vector3 centre = Vector3::Zero();  // of it, in the frame of the whole shape
};

Core core_of(const collision::Shape& shape) {
  const double off = core_share * shape.inner_radius;
  switch (shape.kind) {
    case ShapeKind::Capsule:
      return {collision::Shape::capsule(shape.radius - off, shape.half_height)};
    case ShapeKind::Box:
      return {collision::Shape::box(shape.half_extents - Vector3::Constant(off))};
    case ShapeKind::Cylinder:
      return {collision::Shape::cylinder(shape.radius - off, shape.half_height - off)};
    default:
      return {collision::Shape::sphere(shape.inner_radius - off), collision::mass_properties(shape).centre};
  }
}

// Two solids at the start of a step that can't meet in it: the plane across the line of their centres keeps them
// apart, where the surfaces come towards each other by `closing` at most, of which `shift` (of the first against the
// second) is known by its direction.
bool pass_by(const collision::Shape& first, const collision::Pose& at_first, const collision::Shape& second,
             const collision::Pose& at_second, const Vector3& shift, double closing, double goal) {
  const auto [direction, gap] = collision::centre_line(first, at_first, second, at_second);
  return gap - goal > closing - shift.norm() + std::max(0.0, shift.dot(direction));
}

// Of a solid that starts at the other's surface: it ends off it, and on the same side. What touches for long and turns
// far in a step is not to be held where it is.
bool stays_outside(const collision::Shape& solid, const Motion& motion, const collision::Shape& other,
                   const Motion& other_motion) {
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  collision::Distance before, after;
  collision::find_distance(solid, motion.at(0), other, other_motion.at(0), anywhere, before);
  collision::find_distance(solid, motion.at(1), other, other_motion.at(1), anywhere, after);
  return before.distance > 0 && after.distance > 0 && before.normal.dot(after.normal) > 0;
}

collision::Pose to_collision(const solver::BodyPose& pose) { return {pose.position, pose.orientation}; }

}  // namespace

// How a body moved in this step, if it was fast; else it counts as being where it is now.
const World::Impl::FastMove* World::Impl::find_fast(std::uint32_t body) const {
  const std::uint32_t place = fast_place_[body];
  return place == 0 ? nullptr : &fast_in_order_[place - 1];
}

// The collider's motion in this step, of its shape or of a part of it that is centred at `centre`.
collision::Motion World::Impl::step_motion(std::uint32_t collider, const Vector3& centre) const {
  const std::uint32_t body = colliders.body[collider];
  const collision::PoseView poses{bodies.positions.data(), bodies.orientations.data()};
  collision::Pose local = colliders.local[collider];
  local.position += local.orientation * centre;
  const collision::Pose end = placed(poses[body], local);
  const FastMove* fast = find_fast(body);
  if (!fast) return Motion::still(end);
  // In the shape's frame the body's centre of mass, about which it turns.
  const Vector3 pivot = -(local.orientation.conjugate() * local.position);
  return Motion::between(placed(to_collision(fast->start), local), end, pivot);
}

// Everywhere that the body has been in this step.
collision::Aabb World::Impl::swept_box(const FastMove& fast) const {
  const Vector3 reach = Vector3::Constant(bodies.radius[fast.body]);
  const Vector3 end = bodies.position(fast.body);
  return collision::Aabb::around(fast.start.position.cwiseMin(end) - reach, fast.start.position.cwiseMax(end) + reach);
}

double World::Impl::first_hit(const FastMove& fast, std::vector<std::uint32_t>& nearby) const {
  double first = 1;
  const collision::PoseView poses{bodies.positions.data(), bodies.orientations.data()};
  nearby.clear();
  broadphase.query_box(swept_box(fast), [&](std::uint32_t other) { nearby.push_back(other); });
  std::sort(nearby.begin(), nearby.end());
  for_each_collider(fast.body, [&](std::uint32_t collider) {
    const collision::Shape& shape = colliders.shape[collider];
    const Motion motion = step_motion(collider, Vector3::Zero());
    for (const std::uint32_t other : nearby) {
      if (other == collider || !broadphase.allowed(collider, other)) continue;
      const std::uint32_t body = colliders.body[other];
      const FastMove* moved = find_fast(body);
      const Vector3 shift = moved ? Vector3(fast.shift - moved->shift) : fast.shift;
      // How far the surfaces may have come towards each other. Up to half the smaller one's size the speculative margin
      // has seen it coming.
      const double closing = shift.norm() + fast.turn + (moved ? moved->turn : 0);
      const double size = std::min(shape.inner_radius, colliders.shape[other].inner_radius);
      if (closing <= collision::approach_share * size) continue;
      // Before the look-up in the cache, as most of what is near is passed by.
      if (collision::is_convex_solid(colliders.shape[other].kind)) {
        const collision::Pose at =
            moved ? placed(to_collision(moved->start), colliders.local[other]) : colliders.pose(other, poses);
        const double goal = (stop_share + 1e-3) * size;
        if (pass_by(shape, motion.start, colliders.shape[other], at, shift, closing, goal)) continue;
      }
      const Motion other_motion = step_motion(other, Vector3::Zero());
      collision::SweepHit hit;
      if (!cache.touches(collision::Pair::of(collider, other))) {
        const collision::SweepGoal goal{stop_share * size, 1e-3 * size};
        if (!collision::sweep(shape, motion, colliders.shape[other], other_motion, goal, first, hit)) continue;
        if (!hit.started_overlapping && hit.t > 0) {
          first = hit.t;
          continue;
        }
      }
      const Core core = core_of(shape);
      const Motion core_motion = step_motion(collider, core.centre);
      const collision::SweepGoal goal{0, 1e-3 * size};
      if (!collision::sweep(core.shape, core_motion, colliders.shape[other], other_motion, goal, first, hit) ||
          hit.started_overlapping) {
        continue;
      }
      if (hit.t == 0 && stays_outside(core.shape, core_motion, colliders.shape[other], other_motion)) continue;
      first = hit.t;
    }
  });
  return first;
}

void World::Impl::list_fast_bodies() {
  fast_in_order_.clear();
  fast_.for_each([this](std::vector<solver::FastBody>& of_worker) {
    for (const solver::FastBody& fast : of_worker) {
      // A body that is put back tears the joints that hold it to others, which have gone on.
      if (with_joints && is_joined(fast.body) && !records.continuous[fast.body]) continue;
      // An arc of up to half a turn is at most pi / 2 times its chord.
      const Quaternion change = fast.start.orientation.conjugate() * bodies.orientation(fast.body);
      fast_in_order_.push_back({fast.body, fast.start, bodies.position(fast.body) - fast.start.position,
                                std::numbers::pi * bodies.radius[fast.body] * change.vec().norm()});
    }
  });
  if (fast_in_order_.empty()) return;
  std::sort(fast_in_order_.begin(), fast_in_order_.end(),
            [](const FastMove& x, const FastMove& y) { return x.body < y.body; });
  fast_place_.resize(bodies.size());
  for (std::uint32_t i = 0; i < fast_in_order_.size(); ++i) fast_place_[fast_in_order_[i].body] = i + 1;
}

void World::Impl::sweep_fast_bodies() {
  list_fast_bodies();
  if (fast_in_order_.empty()) return;

  // For fast bodies to find each other their boxes must show where they went, as those that were stretched along the
  // motion often do. All are swept along the motion that the solver gave them before any is put back.
  rushed_.clear();
  for (const FastMove& fast : fast_in_order_) {
    if (!is_finite(fast.body)) continue;
    const collision::Aabb swept = swept_box(fast);
    bool rushed = false;
    for_each_collider(fast.body, [&](std::uint32_t collider) {
      if (broadphase.fat_box(collider).contains(swept)) return;
      broadphase.move_box(collider, swept);
      rushed = true;
    });
    if (rushed) rushed_.push_back(fast.body);
  }
  first_hits_.resize(fast_in_order_.size());
  std::fill(first_hits_.begin(), first_hits_.end(), 1.0);
  arena.parallel_for(fast_in_order_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!is_finite(fast_in_order_[i].body)) continue;
      first_hits_[i] = first_hit(fast_in_order_[i], nearby_.local());
    }
  });
  for (std::size_t i = 0; i < fast_in_order_.size(); ++i) {
    if (first_hits_[i] >= 1) continue;
    const FastMove& fast = fast_in_order_[i];
    const Motion motion = Motion::between(to_collision(fast.start),
                                          {bodies.position(fast.body), bodies.orientation(fast.body)}, Vector3::Zero());
    const collision::Pose pose = motion.at(first_hits_[i]);
    bodies.position(fast.body) = pose.position;
    bodies.set_orientation(fast.body, pose.orientation);
    look_again(fast.body);
    ++report_.counts.stopped;
  }
  for (const std::uint32_t body : rushed_) move_proxies(body);
  for (const FastMove& fast : fast_in_order_) fast_place_[fast.body] = 0;
  report_.counts.swept = static_cast<std::int64_t>(fast_in_order_.size());
}

}  // namespace atl
