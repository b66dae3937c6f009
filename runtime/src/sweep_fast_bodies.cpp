// Continuous collision: bodies that moved far in a step are put back to where they first met something in their
// way, so that the next step finds the contact. What touches with its core already slides along what it touches. They
// keep their velocity. Only these bodies cost anything. What joints connect is put back together: fast_assemblies.cpp.

#include <collision/continuous/sweep.h>
#include <collision/queries/distance.h>
#include <collision/shapes/convex.h>
#include <jobs/with_joints.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "world_impl.h"

namespace atl {
namespace {

using collision::Motion;
using collision::ShapeKind;

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

// No point of such a shape is farther from its core than the core is deep, but for corners of boxes.
bool has_even_core(ShapeKind kind) { return kind <= ShapeKind::Cylinder; }

// Of a solid that starts at the other's surface: it ends off it, and on the same side.
bool stays_outside(const collision::Shape& solid, const Motion& motion, const collision::Shape& other,
                   const Motion& other_motion) {
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  collision::Distance before, after;
  collision::find_distance(solid, motion.at(0), other, other_motion.at(0), anywhere, before);
  collision::find_distance(solid, motion.at(1), other, other_motion.at(1), anywhere, after);
  return before.distance > 0 && after.distance > 0 && before.normal.dot(after.normal) > 0;
}

// How far beyond the plane of the hit the core ends.
HeldBy held_by(const collision::SweepHit& hit, const Motion& other, const collision::Shape& core,
               const collision::Pose& end, double slack) {
  const collision::Pose other_end = other.at(1);
  const Vector3 point = other_end.position + other_end.orientation * (other.start.orientation.conjugate() *
                                                                      (hit.point - other.start.position));
  const double reach = collision::reach_along(core, end.orientation.conjugate() * hit.normal);
  return {hit.normal, hit.normal.dot(end.position - point) + reach, slack};
}

// The way that takes a core off all that it is held by: before one plane after the other until none is passed. A core
// that started overlapping would be let through.
std::optional<Vector3> way_aside(std::span<const HeldBy> held) {
  constexpr int rounds = 20;
  Vector3 aside = Vector3::Zero();
  for (int round = 0; round < rounds; ++round) {
    bool passed = false;
    for (const HeldBy& surface : held) {
      const double excess = surface.excess + surface.normal.dot(aside);
      if (excess <= -0.25 * surface.slack) continue;
      aside -= (excess + 0.5 * surface.slack) * surface.normal;
      passed = true;
    }
    if (!passed) return aside;
  }
  return std::nullopt;
}

}  // namespace

// How a body moved in this step, if it was fast; else it counts as being where it is now.
const FastMove* World::Impl::find_fast(std::uint32_t body) const {
  const std::uint32_t place = fast_place_[body];
  return place == 0 ? nullptr : &fast_in_order_[place - 1];
}

// The collider's motion in this step, of its shape or of a part of it that is centred at `centre`, if its body ends
// `aside` of where it did.
collision::Motion World::Impl::step_motion(std::uint32_t collider, const Vector3& centre, const Vector3& aside) const {
  const std::uint32_t body = colliders.body[collider];
  const collision::PoseView poses{bodies.positions.data(), bodies.orientations.data()};
  collision::Pose local = colliders.local[collider];
  local.position += local.orientation * centre;
  collision::Pose end = placed(poses[body], local);
  end.position += aside;
  const FastMove* fast = find_fast(body);
  if (!fast) return Motion::still(end);
  // In the shape's frame the body's centre of mass, about which it turns.
  const Vector3 pivot = -(local.orientation.conjugate() * local.position);
  return Motion::between(placed(fast->start_pose(), local), end, pivot);
}

// When the body first meets something, as part of the step, up to `first`, if it ends `aside` of where it did. What it
// touches with its core from the start is added to what it is held by, and doesn't stop it.
double World::Impl::first_hit(const FastMove& fast, const Vector3& aside, double first, FastSweep& scratch) const {
  const bool joined = fast.assembly != FastMove::alone;
  for_each_collider(fast.body, [&](std::uint32_t collider) {
    const collision::Shape& shape = colliders.shape[collider];
    find_approaching(fast, aside, collider, scratch);
    if (scratch.approaching.empty()) return;
    const Motion motion = step_motion(collider, Vector3::Zero(), aside);
    const bool only_deep = joined && !records.continuous[fast.body] && has_even_core(shape.kind);
    for (const Approach& approach : scratch.approaching) {
      const std::uint32_t other = approach.other;
      const double tolerance = sweep_tolerance * approach.size;
      const Motion other_motion = step_motion(other, Vector3::Zero(), Vector3::Zero());
      const collision::SweepGoal goal{stop_share * approach.size, tolerance};
      collision::SweepHit hit;
      if (approach.apart && !only_deep) {
        if (!collision::sweep(shape, motion, colliders.shape[other], other_motion, goal, first, hit)) continue;
        if (!hit.started_overlapping && hit.t > 0) {
          first = hit.t;
          continue;
        }
      }
      if (approach.passes_core) continue;
      const Core core = core_of(shape);
      const Motion core_motion = core.centre.isZero(0) ? motion : step_motion(collider, core.centre, aside);
      if (!collision::sweep(core.shape, core_motion, colliders.shape[other], other_motion, {0, tolerance}, first,
                            hit) ||
          hit.started_overlapping) {
        continue;
      }
      if (hit.t > 0) {
        first = hit.t;
        if (!approach.apart || !only_deep) continue;
        collision::SweepHit surface;
        collision::sweep(shape, motion, colliders.shape[other], other_motion, goal, first, surface);
        if (surface.t > 0) first = std::min(first, surface.t);
        continue;
      }
      // What is shifted together stays as it is.
      if (joined && assembly_of(colliders.body[other]) == fast.assembly) continue;
      if (stays_outside(core.shape, core_motion, colliders.shape[other], other_motion)) continue;
      scratch.held.push_back(held_by(hit, other_motion, core.shape, core_motion.at(1), tolerance));
    }
  });
  return first;
}

// Where a fast body, or the fast ones of an assembly, may go in this step. What a core touches from the start would
// hold it where it is, for good, if other bodies press on it: it goes all its way but for what would take the core
// through the surfaces that it touches. An assembly is shifted as one.
FastStop World::Impl::find_stop(std::span<const FastMove> together, FastSweep& scratch) const {
  const auto meet = [&](const Vector3& aside, const auto& find_nearby) {
    scratch.held.clear();
    double first = 1;
    for (const FastMove& fast : together) {
      find_nearby(fast);
      first = first_hit(fast, aside, first, scratch);
    }
    return first;
  };
  const double first = meet(Vector3::Zero(), [&](const FastMove& fast) { list_nearby(fast, scratch.nearby); });
  if (scratch.held.empty()) return {first, Vector3::Zero()};
  const std::optional<Vector3> aside = way_aside(scratch.held);
  if (!aside || !may_shift(together.front(), *aside)) return {0, Vector3::Zero()};
  const double first_aside = meet(*aside, [&](const FastMove& fast) { query_nearby(fast, *aside, scratch.nearby); });
  const bool kept_off =
      std::all_of(scratch.held.begin(), scratch.held.end(), [](const HeldBy& surface) { return surface.excess <= 0; });
  return kept_off ? FastStop{first_aside, *aside} : FastStop{0, Vector3::Zero()};
}

void World::Impl::list_fast_bodies() {
  fast_in_order_.clear();
  fast_.for_each([this](const solver::MovedBodies& of_worker) {
    for (const solver::MovedBody& fast : of_worker.fast) {
      // An arc of up to half a turn is at most pi / 2 times its chord.
      const Quaternion change = fast.start.orientation.conjugate() * bodies.orientation(fast.body);
      const double radius = bodies.radius[fast.body];
      const Vector3 shift = bodies.position(fast.body) - fast.start.position;
      const std::uint32_t assembly = assembly_of(fast.body);
      if (assembly != FastMove::alone && !records.continuous[fast.body]) {
        // Up to there nothing gets to its core that the speculative margin hasn't seen.
        const double far = bodies.reach_limit[fast.body] * (1 + core_share / collision::approach_share);
        if (shift.norm() + 2 * radius * change.vec().norm() <= far) continue;
      }
      fast_in_order_.push_back({.body = fast.body,
                                .assembly = assembly,
                                .start = fast.start,
                                .shift = shift,
                                .turn = std::numbers::pi * radius * change.vec().norm(),
                                .bulge = radius * (1 - std::min(1.0, std::abs(change.w())))});
    }
  });
  if (fast_in_order_.empty()) return;
  // Those alone come last.
  std::sort(fast_in_order_.begin(), fast_in_order_.end(), [](const FastMove& x, const FastMove& y) {
    return x.assembly != y.assembly ? x.assembly < y.assembly : x.body < y.body;
  });
  fast_place_.resize(bodies.size());
  for (std::uint32_t i = 0; i < fast_in_order_.size(); ++i) fast_place_[fast_in_order_[i].body] = i + 1;
}

void World::Impl::sweep_fast_bodies() {
  list_fast_bodies();
  // Kinematic bodies alone meet nobody who would be stopped.
  const auto dynamic = [this](const FastMove& fast) { return records.dynamic[fast.body] != 0; };
  if (std::none_of(fast_in_order_.begin(), fast_in_order_.end(), dynamic)) {
    for (const FastMove& fast : fast_in_order_) fast_place_[fast.body] = 0;
    return;
  }

  find_near_fast();
  list_together();
  stops_.assign(together_.size(), FastStop{});
  arena.parallel_for(together_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::span<const FastMove> moves = moves_together(i);
      const bool sound =
          std::all_of(moves.begin(), moves.end(), [this](const FastMove& f) { return is_finite(f.body); });
      if (sound && dynamic(moves.front())) stops_[i] = find_stop(moves, sweep_scratch_.local());
    }
  });
  const auto stops = [](const FastStop& found) { return found.stops(); };
  if (with_joints && std::any_of(stops_.begin(), stops_.end(), stops)) list_carried();
  for (std::size_t i = 0; i < together_.size(); ++i) {
    if (stops_[i].stops()) stop(i, stops_[i]);
  }
  for (const FastMove& fast : fast_in_order_) {
    if (fast.rushed) move_proxies(fast.body);
    fast_place_[fast.body] = 0;
    report_.counts.swept += records.dynamic[fast.body];
  }
}

}  // namespace atl
