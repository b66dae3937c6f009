#include "step/continuous_phase.h"

#include <features/with_joints.h>
#include <jobs/arrays.h>
#include <jobs/assert.h>
#include <solver/constraints/joint.h>
#include <solver/integrate/free_flight.h>
#include <solver/integrate/motion.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <numbers>

#include "world/colliders.h"
#include "world/joints.h"

namespace atl {

using collision::CcdStop;
using collision::FastBody;
using collision::Motion;

namespace {

bool comes_first(const FastBody& x, const FastBody& y) {
  return x.assembly != y.assembly ? x.assembly < y.assembly : x.body < y.body;
}

// By number, what joints connect a body to; alone if none acts on it.
std::uint32_t assembly_of(const Stores& world, const IslandPhase& islands, std::uint32_t body) {
  return world.bodies.joined[body] ? islands.assembly_of(body) : FastBody::alone;
}

// Updates a joint's coordinates after its bodies were moved, by less than half a turn.
void follow_position(const Stores& world, solver::Joint& joint) {
  if (joint.is_tendon()) {
    follow_length(world, joint);
    return;
  }
  const solver::JointFrames frames = frames_of(world, joint);
  for (std::size_t row = 0; row < joint.rows; ++row) {
    const double value = joint_row(joint, row, frames).value;
    joint.position[row] = solver::continued(joint.coordinate[row], value, joint.position[row]);
  }
}

}  // namespace

// How a body moved that may have been fast.
FastBody ContinuousPhase::fast_body(const Stores& world, const IslandPhase& islands,
                                    const solver::MovedBody& moved) const {
  const std::uint32_t body = moved.body;
  // An arc of up to half a turn is at most pi / 2 times its chord.
  const Quaternion change = moved.start.orientation.conjugate() * world.bodies.orientation(body);
  const double radius = world.bodies.radius[body];
  const std::uint32_t assembly = assembly_of(world, islands, body);
  // An assembly that would go far waits where it started until its contacts have slowed it: it may hang on the world,
  // and those of its bodies that aren't fast look for nothing in their way.
  const double alone_limit = world.bodies.locks[body] == 0 ? std::numeric_limits<double>::infinity() : -1;
  return {.body = body,
          .assembly = assembly,
          .start = {moved.start.position, moved.start.orientation},
          .shift = world.bodies.position(body) - moved.start.position,
          .turn = std::numbers::pi * radius * change.vec().norm(),
          .bulge = radius * (1 - std::min(1.0, std::abs(change.w()))),
          .stops = world.records.dynamic[body] != 0,
          .always_swept = world.records.continuous[body] != 0,
          .on_surface = std::ranges::binary_search(on_surfaces_, body, {}, &OnSurface::body),
          .aside_limit = assembly == FastBody::alone ? alone_limit : world.aabbs.bounds.margin_limit[body]};
}

// Has a body noted that moves farther than this (m) in the step.
void ContinuousPhase::watch(Stores& world, std::uint32_t body, double distance) {
  double& sweep_distance = world.aabbs.bounds.sweep_distance[body];
  if (sweep_distance < 0 || sweep_distance == std::numeric_limits<double>::infinity()) return;
  on_surfaces_.push_back({body, sweep_distance});
  sweep_distance = std::min(sweep_distance, distance);
}

// Bodies that something kinematic may pass over by more than speculative contacts reach, and that itself, are looked at
// however little they move.
void ContinuousPhase::watch_what_is_passed(Stores& world) {
  if (world.contents.kinematic == 0) return;
  constexpr double however_little = -1;
  for (const std::uint32_t body : world.active.in_order()) {
    // A half-space has no front that could be past somebody: it pushes out whoever is in it.
    constexpr double unbounded = std::numeric_limits<double>::infinity();
    if (world.records.type[body] != BodyType::Kinematic || world.aabbs.bounds.sweep_distance[body] == unbounded)
      continue;
    const double spin = world.bodies.angular_velocity(body).norm();
    const double moves = world.clock.dt * (world.bodies.velocity(body).norm() + spin * world.bodies.radius[body]);
    world.cache.for_each_contact_of(body, [&](std::uint32_t slot) {
      const collision::Contact& contact = world.cache.contacts[slot];
      const std::uint32_t other = contact.body_first == body ? contact.body_second : contact.body_first;
      if (!world.records.dynamic[other] || !(moves > collision::approach_share * contact.size)) return;
      watch(world, body, however_little);
      watch(world, other, however_little);
    });
  }
}

void ContinuousPhase::watch_surface_contacts(Stores& world, const ContactPhase& contacts) {
  watch_what_is_passed(world);
  if (world.contents.surfaces == 0) return;
  const auto is_surface = [&](std::uint32_t body) {
    return !world.records.dynamic[body] &&
           collision::is_surface(world.colliders.shape[world.colliders.first[body]].kind);
  };
  for (const solver::TouchingPair& pair : contacts.touching()) {
    const auto& separation = world.cache.manifolds[pair.slot].separation;
    const double deepest = *std::min_element(std::begin(separation), std::end(separation));
    const double size = world.cache.contacts[pair.slot].size;
    const double way = collision::core_share * size + deepest;
    const bool of_second = world.records.dynamic[pair.second] != 0;
    if (!is_surface(of_second ? pair.first : pair.second)) continue;
    const std::uint32_t body = of_second ? pair.second : pair.first;
    const double sweep_distance = world.aabbs.bounds.sweep_distance[body];
    if (way < std::max<double>(sweep_distance, collision::approach_share * size))
      watch(world, body, std::max(way, 0.0));
  }
}

void ContinuousPhase::unwatch(Stores& world) {
  // The last that is put back of a body is the first that was noted.
  for (auto on_surface = on_surfaces_.rbegin(); on_surface != on_surfaces_.rend(); ++on_surface) {
    world.aabbs.bounds.sweep_distance[on_surface->body] = on_surface->sweep_distance;
  }
  std::ranges::sort(on_surfaces_, {}, &OnSurface::body);
}

void ContinuousPhase::list_fast_bodies(const Stores& world, const IslandPhase& islands, solver::FastBodies& moved) {
  fast_in_order_.clear();
  moved.for_each([&](const solver::MovedBodies& of_worker) {
    for (const solver::MovedBody& body : of_worker.fast) {
      const FastBody fast = fast_body(world, islands, body);
      if (fast.assembly != FastBody::alone && !fast.always_swept && !fast.on_surface) {
        // Up to there nothing gets to its core that the speculative margin hasn't seen.
        const double far =
            world.aabbs.bounds.margin_limit[fast.body] * (1 + collision::core_share / collision::approach_share);
        if (fast.shift.norm() + 2 * std::numbers::inv_pi * fast.turn <= far) continue;
      }
      fast_in_order_.push_back(fast);
    }
  });
  std::sort(fast_in_order_.begin(), fast_in_order_.end(), comes_first);
}

// The bodies that aren't fast of assemblies that stop, where they started, in order.
void ContinuousPhase::list_carried(const Stores& world, const IslandPhase& islands, solver::FastBodies& moved,
                                   std::span<const CcdStop> stops) {
  carried_.clear();
  const auto stopped = [&](std::uint32_t assembly) {
    const auto assembly_of_stop = [](const CcdStop& stop) { return stop.bodies.front().assembly; };
    const auto found = std::ranges::lower_bound(stops, assembly, {}, assembly_of_stop);
    return found != stops.end() && assembly_of_stop(*found) == assembly && found->stops();
  };
  moved.for_each([&](const solver::MovedBodies& of_worker) {
    for (const solver::MovedBody& joined : of_worker.joined) {
      const std::uint32_t assembly = assembly_of(world, islands, joined.body);
      if (assembly == FastBody::alone || !stopped(assembly)) continue;
      const FastBody carried = fast_body(world, islands, joined);
      if (!std::ranges::binary_search(fast_in_order_, carried, comes_first)) carried_.push_back(carried);
    }
  });
  std::sort(carried_.begin(), carried_.end(), comes_first);
}

// Ends the step of a fast body, or of an assembly, where it met something. Each body is put on the straight way of its
// centre, turned evenly about it. Where bodies turned by an angle a in the step, joints open by that by up to a^2 / 8
// of how far they are from these centres, until the next step closes them.
void ContinuousPhase::stop(Stores& world, const IslandPhase& islands, const CcdStop& stop, StepCounts& counts) const {
  const auto put_back = [&](const FastBody& fast) {
    const std::uint32_t body = fast.body;
    const collision::Pose end{world.bodies.position(body) + stop.aside, world.bodies.orientation(body)};
    const collision::Pose pose = stop.t >= 1 ? end : Motion::between(fast.start, end, Vector3::Zero()).at(stop.t);
    const Vector3 fall = world.clock.dt * world.bodies.gravity_scale[body] * world.gravity;
    // A body in free flight loses the speed that its weight would have added after the stop.
    const Vector3 flown = world.clock.dt * (world.bodies.velocity(body) - 0.5 * fall);
    const bool flies = (fast.shift - flown).norm() <= 1e-3 * world.clock.dt * fall.norm();
    if (flies) {
      if (stop.t < 1) world.bodies.velocity(body) -= (1 - stop.t) * fall;
    } else {
      // The work of its weight on the way that it doesn't go: it would gain that in each step that it is stopped.
      ATL_ASSERT(world.bodies.inverse_mass[body] > 0, body, world.bodies.inverse_mass[body]);
      const Vector3 weight = world.bodies.gravity_scale[body] / world.bodies.inverse_mass[body] * world.gravity;
      const double undone = weight.dot(world.bodies.position(body) - pose.position);
      if (undone > 0) solver::slow_down(world.bodies, {&body, 1}, solver::Momentum::Take, undone);
    }
    world.bodies.position(body) = pose.position;
    solver::turn_back(world.bodies, body, pose.orientation);
    world.aabbs.mark_dirty(body);
    ++counts.stopped;
  };
  for (const FastBody& fast : stop.bodies) put_back(fast);
  const std::uint32_t assembly = stop.bodies.front().assembly;
  if (assembly == FastBody::alone) return;
  auto carried = std::ranges::lower_bound(carried_, assembly, {}, &FastBody::assembly);
  for (; carried != carried_.end() && carried->assembly == assembly; ++carried) put_back(*carried);
  for (const solver::JointLink& link : islands.joint_graph().links_of(assembly)) {
    follow_position(world, world.joints.joints[link.joint]);
  }
}

void ContinuousPhase::sweep(Stores& world, const StepContext& step, const ContactPhase& contacts,
                            const IslandPhase& islands, solver::FastBodies& moved) {
  unwatch(world);
  list_fast_bodies(world, islands, moved);
  on_surfaces_.clear();
  // Kinematic bodies alone meet nobody who would be stopped.
  if (std::ranges::none_of(fast_in_order_, &FastBody::stops)) return;
  const collision::BodyMotions now = motions(world);
  const bool filters = step.rules != nullptr && step.rules->filters();
  const std::span<const collision::Pair> off = contacts.pairs_off();
  std::vector<collision::Pair> passing(off.begin(), off.end()), decided;
  add_in_order(passing, world.choices.refused);
  const auto decide = [&](std::span<const collision::Pair> pairs) -> std::span<const collision::Pair> {
    std::vector<collision::Pair> fresh;
    std::set_difference(pairs.begin(), pairs.end(), decided.begin(), decided.end(), std::back_inserter(fresh));
    add_in_order(decided, fresh);
    const std::vector<collision::Pair> refused = step.rules->refuse(world, fresh);
    add_in_order(world.choices.refused, refused);
    add_in_order(passing, refused);
    return passing;
  };
  const collision::FunctionRef<std::span<const collision::Pair>(std::span<const collision::Pair>)> ask(decide);
  const std::span<const CcdStop> stops = continuous_.find_stops({.motions = now,
                                                                 .turned = world.bodies.turned,
                                                                 .joined = world.bodies.joined,
                                                                 .dynamic = world.records.dynamic,
                                                                 .assembly = islands.assemblies(),
                                                                 .cache = world.cache,
                                                                 .kernels = step.narrowphase_kernels,
                                                                 .active_bodies = world.active.in_order().size(),
                                                                 .passing = passing,
                                                                 .decide = filters ? &ask : nullptr,
                                                                 .fast = fast_in_order_},
                                                                world.broadphase, step.arena);
  if (with_joints && std::ranges::any_of(stops, &CcdStop::stops)) list_carried(world, islands, moved, stops);
  for (const CcdStop& found : stops) {
    if (found.stops()) stop(world, islands, found, step.report.counts);
  }
  for (const FastBody& fast : fast_in_order_) {
    if (fast.left_aabb) move_proxies(world, fast.body);
    step.report.counts.swept += fast.stops;
  }
}

}  // namespace atl
