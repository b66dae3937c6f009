// Continuous collision: bodies that moved far in a step are put back to where they first met something in their
// way. They keep their velocity. What joints connect is put back together: if one of an assembly's fast bodies meets
// something at a part of the step, all its bodies are put where they were then. Static and kinematic bodies connect
// nothing.

#include <collision/continuous/continuous_collision.h>
#include <jobs/with_joints.h>
#include <solver/constraints/joint.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <span>

#include "world/world_impl.h"

namespace atl {

using collision::CcdStop;
using collision::FastBody;
using collision::Motion;

namespace {

bool comes_first(const FastBody& x, const FastBody& y) {
  return x.assembly != y.assembly ? x.assembly < y.assembly : x.body < y.body;
}

}  // namespace

// By number, what joints connect a body to; alone if none acts on it.
std::uint32_t World::Impl::assembly_of(std::uint32_t body) const {
  return bodies.joined[body] ? assembly_[body] : FastBody::alone;
}

// How a body moved that may have been fast.
FastBody World::Impl::fast_body(const solver::MovedBody& moved) const {
  const std::uint32_t body = moved.body;
  // An arc of up to half a turn is at most pi / 2 times its chord.
  const Quaternion change = moved.start.orientation.conjugate() * bodies.orientation(body);
  const double radius = bodies.radius[body];
  const std::uint32_t assembly = assembly_of(body);
  // An assembly that would go far waits where it started until its contacts have slowed it: it may hang on the world,
  // and those of its bodies that aren't fast look for nothing in their way.
  const double alone_limit = bodies.locks[body] == 0 ? std::numeric_limits<double>::infinity() : -1;
  return {.body = body,
          .assembly = assembly,
          .start = {moved.start.position, moved.start.orientation},
          .shift = bodies.position(body) - moved.start.position,
          .turn = std::numbers::pi * radius * change.vec().norm(),
          .bulge = radius * (1 - std::min(1.0, std::abs(change.w()))),
          .stops = records.dynamic[body] != 0,
          .always_swept = records.continuous[body] != 0,
          .aside_limit = assembly == FastBody::alone ? alone_limit : aabbs.bounds.margin_limit[body]};
}

void World::Impl::list_fast_bodies() {
  fast_in_order_.clear();
  fast_.for_each([this](const solver::MovedBodies& of_worker) {
    for (const solver::MovedBody& moved : of_worker.fast) {
      const FastBody fast = fast_body(moved);
      if (fast.assembly != FastBody::alone && !fast.always_swept) {
        // Up to there nothing gets to its core that the speculative margin hasn't seen.
        const double far =
            aabbs.bounds.margin_limit[fast.body] * (1 + collision::core_share / collision::approach_share);
        if (fast.shift.norm() + 2 * std::numbers::inv_pi * fast.turn <= far) continue;
      }
      fast_in_order_.push_back(fast);
    }
  });
  std::sort(fast_in_order_.begin(), fast_in_order_.end(), comes_first);
}

// The bodies that aren't fast of assemblies that stop, where they started, in order.
void World::Impl::list_carried(std::span<const CcdStop> stops) {
  carried_.clear();
  const auto stopped = [&](std::uint32_t assembly) {
    const auto assembly_of_stop = [](const CcdStop& stop) { return stop.bodies.front().assembly; };
    const auto found = std::ranges::lower_bound(stops, assembly, {}, assembly_of_stop);
    return found != stops.end() && assembly_of_stop(*found) == assembly && found->stops();
  };
  fast_.for_each([&](const solver::MovedBodies& of_worker) {
    for (const solver::MovedBody& joined : of_worker.joined) {
      const std::uint32_t assembly = assembly_of(joined.body);
      if (assembly == FastBody::alone || !stopped(assembly)) continue;
      const FastBody carried = fast_body(joined);
      if (!std::ranges::binary_search(fast_in_order_, carried, comes_first)) carried_.push_back(carried);
    }
  });
  std::sort(carried_.begin(), carried_.end(), comes_first);
}

// Ends the step of a fast body, or of an assembly, where it met something. Each body is put on the straight way of its
// centre, turned evenly about it. Where bodies turned by an angle a in the step, joints open by that by up to a^2 / 8
// of how far they are from these centres, until the next step closes them.
void World::Impl::stop(const CcdStop& stop) {
  const auto put_back = [&](const FastBody& fast) {
    const std::uint32_t body = fast.body;
    const collision::Pose end{bodies.position(body) + stop.aside, bodies.orientation(body)};
    const collision::Pose pose = stop.t >= 1 ? end : Motion::between(fast.start, end, Vector3::Zero()).at(stop.t);
    bodies.position(body) = pose.position;
    bodies.set_orientation(body, pose.orientation);
    aabbs.mark_dirty(body);
    ++report_.counts.stopped;
  };
  for (const FastBody& fast : stop.bodies) put_back(fast);
  const std::uint32_t assembly = stop.bodies.front().assembly;
  if (assembly == FastBody::alone) return;
  for (const FastBody& carried : std::ranges::equal_range(carried_, assembly, {}, &FastBody::assembly)) {
    put_back(carried);
  }
  for (const solver::JointLink& link : joint_graph_.links_of(assembly)) follow_position(joints.joints[link.joint]);
}

// Of a joint whose bodies were put elsewhere, by less than half a turn.
void World::Impl::follow_position(solver::Joint& joint) const {
  const solver::JointFrames frames = frames_of(joint);
  for (std::size_t row = 0; row < joint.rows; ++row) {
    const double value = joint_row(joint, row, frames).value;
    joint.position[row] = solver::continued(joint.coordinate[row], value, joint.position[row]);
  }
}

void World::Impl::sweep_fast_bodies() {
  list_fast_bodies();
  // Kinematic bodies alone meet nobody who would be stopped.
  if (std::ranges::none_of(fast_in_order_, &FastBody::stops)) return;
  const collision::BodyMotions now = motions();
  const std::span<const CcdStop> stops = continuous_.find_stops({.motions = now,
                                                                 .turned = bodies.turned,
                                                                 .joined = bodies.joined,
                                                                 .assembly = assembly_,
                                                                 .cache = cache,
                                                                 .kernels = *narrowphase_kernels,
                                                                 .active_bodies = active_.in_order().size(),
                                                                 .fast = fast_in_order_},
                                                                broadphase, arena);
  if (with_joints && std::ranges::any_of(stops, &CcdStop::stops)) list_carried(stops);
  for (const CcdStop& found : stops) {
    if (found.stops()) stop(found);
  }
  for (const FastBody& fast : fast_in_order_) {
    if (fast.left_aabb) move_proxies(fast.body);
    report_.counts.swept += fast.stops;
  }
}

}  // namespace atl
