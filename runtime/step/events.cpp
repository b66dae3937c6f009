#include "step/events.h"

#include <features/with_joints.h>
#include <jobs/assert.h>
#include <solver/constraints/tendon.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "step/contact_phase.h"
#include "step/results.h"
#include "world/bodies.h"
#include "world/joints.h"

namespace atl {
namespace {

// Speculative points count from when they carry something.
bool touches(const collision::Contact& contact, const collision::ContactManifold& manifold) {
  for (std::size_t i = 0; i < contact.count; ++i) {
    if (manifold.separation[i] <= 0 || manifold.normal_impulse[i] != 0) return true;
  }
  return false;
}

// Hits are told apart by all that they are.
bool precedes(const ContactHit& x, const ContactHit& y) {
  return std::tie(x.a, x.b, x.child_a, x.child_b, x.impulse, x.approach) <
         std::tie(y.a, y.b, y.child_a, y.child_b, y.impulse, y.approach);
}

// m/s: how fast a contact's points closed as the step began, the fastest. Its manifold is as it was then.
double approach_of(const Stores& world, std::uint32_t slot, std::span<const BodyVelocity> velocities) {
  const collision::Contact& contact = world.cache.contacts[slot];
  const collision::ContactManifold& manifold = world.cache.manifolds[slot];
  const ManifoldPlace place = place_of(world, contact, manifold);
  const auto velocity_at = [&](std::uint32_t body, const Vector3& arm) -> Vector3 {
    if (!world.active.contains(body)) return Vector3::Zero();
    return velocities[body].linear + velocities[body].angular.cross(arm);
  };
  const auto anchor = [](const float(&of)[3]) { return Vector3(of[0], of[1], of[2]); };
  const Vector3 apart = anchor(manifold.anchor_second) - anchor(manifold.anchor_first);
  double fastest = 0;
  for (std::size_t i = 0; i < contact.count; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;  // switched off
    const Vector3 arm = place.point(manifold, i) - world.bodies.position(contact.body_first);
    const Vector3 parting = velocity_at(contact.body_second, arm + apart) - velocity_at(contact.body_first, arm);
    fastest = std::max(fastest, -place.normal.dot(parting));
  }
  return fastest;
}

ContactHit hit_of(const Stores& world, std::uint32_t slot, const ContactPushes& pushes) {
  const collision::Contact& contact = world.cache.contacts[slot];
  const auto end = [&](std::uint32_t collider) {
    return std::pair(id_of(world, world.colliders.body[collider]), world.colliders.child[collider]);
  };
  auto a = end(contact.pair.first), b = end(contact.pair.second);
  if (b < a) std::swap(a, b);
  return {.a = a.first,
          .b = b.first,
          .child_a = a.second,
          .child_b = b.second,
          .impulse = std::max(0.0f, pushes.impulse[slot]),
          .approach = approach_of(world, slot, pushes.velocities)};
}

// Sums up all hits of two bodies.
void add_to_event(std::span<const ContactHit> hits, ContactEvent& event) {
  double max = -1;
  for (const ContactHit& hit : hits) {
    event.impulse += hit.impulse;
    event.approach_speed = std::max(event.approach_speed, hit.approach);
    if (hit.impulse <= max) continue;
    max = hit.impulse;
    event.child_a = hit.child_a;
    event.child_b = hit.child_b;
  }
}

// The event of two bodies that touch. `before`: their hits by contacts that don't touch as the step ends.
ContactEvent touch(const Stores& world, const std::pair<BodyId, BodyId>& pair, std::span<const ContactHit> before,
                   const ContactPushes& pushes, double substep) {
  ATL_ASSERT(pair.first < pair.second, pair.first.index, pair.second.index);
  ContactEvent event{.a = pair.first, .b = pair.second, .began = true};
  std::vector<ContactHit> hits(before.begin(), before.end());
  Vector3 by_force[2] = {Vector3::Zero(), Vector3::Zero()};
  Vector3 by_number[2] = {Vector3::Zero(), Vector3::Zero()};
  double points = 0;
  const BodyId a = pair.first, b = pair.second;
  world.cache.for_each_contact_of(world.records.dynamic[a.index] ? a.index : b.index, [&](std::uint32_t slot) {
    const collision::Contact& contact = world.cache.contacts[slot];
    const auto [first, second] = std::minmax(contact.body_first, contact.body_second);
    if (first != a.index || second != b.index || contact.count == 0) return;
    const collision::ContactManifold& manifold = world.cache.manifolds[slot];
    if (touches(contact, manifold)) hits.push_back(hit_of(world, slot, pushes));
    const ManifoldPlace place = place_of(world, contact, manifold);
    const Vector3 normal = contact.body_first == a.index ? place.normal : Vector3(-place.normal);
    for (std::size_t i = 0; i < contact.count; ++i) {
      if (manifold.separation[i] >= collision::no_point) continue;  // switched off
      const double force = std::max(0.0, std::abs(static_cast<double>(manifold.normal_impulse[i]))) / substep;
      const Vector3 point = place.point(manifold, i);
      event.normal_force += force;
      by_force[0] += force * point;
      by_force[1] += force * normal;
      by_number[0] += point;
      by_number[1] += normal;
      ++points;
    }
  });
  // In an order that doesn't follow from when contacts came.
  std::sort(hits.begin(), hits.end(), precedes);
  add_to_event(hits, event);
  if (points == 0) return event;
  const bool presses = event.normal_force > 0;
  event.point = presses ? Vector3(by_force[0] / event.normal_force) : Vector3(by_number[0] / points);
  event.normal = (presses ? by_force[1] : by_number[1]).stableNormalized();
  return event;
}

// N: the least that a contact of two bodies has to carry for an event of its going on; infinite where nobody asks.
double event_force(const Stores& world, BodyId a, BodyId b) {
  constexpr double never = std::numeric_limits<double>::infinity();
  double min = world.settings.contact_event_force.value_or(never);
  if (world.contents.with_event_force == 0) return min;
  for (const BodyId id : {a, b}) {
    min = std::min(min, world.records.constants[id.index]->contact_event_force.value_or(never));
  }
  return min;
}

// Bodies may have several contacts with each other, so what counts is the list of bodies that touch. Of two bodies all
// contacts are idle or none is, and idle ones touch as they did.
void record_events(Stores& world, ContactEvents& events, const ContactPushes& pushes, std::vector<ContactHit>& hits,
                   bool islands_rebuilt, const StepContext& step) {
  events.events.clear();
  // Nobody touched in the last step who could stop in this.
  if (events.reported && !islands_rebuilt && events.now.empty() && world.cache.order().empty()) return;
  const auto id = [&](std::uint32_t body) { return id_of(world, body); };
  const auto is_idle = [&](const std::pair<BodyId, BodyId>& pair) {
    const auto [a, b] = pair;
    return !world.active.contains(a.index) && !world.active.contains(b.index) && world.records.alive[a.index] &&
           world.records.alive[b.index] && a == id(a.index) && b == id(b.index) &&
           !world.quarantine.contains(a.index) && !world.quarantine.contains(b.index);
  };
  std::swap(events.touched, events.before);
  events.now.clear();
  if (!events.reported && world.settings.contact_events)
    place_idle_contacts(world, step.narrowphase_kernels, step.arena);
  for (const std::uint32_t slot : events.reported ? world.cache.order().slots() : world.cache.all_in_order()) {
    const collision::Contact& contact = world.cache.contacts[slot];
    if (!touches(contact, world.cache.manifolds[slot])) continue;
    const auto [a, b] = std::minmax(contact.body_first, contact.body_second);
    events.now.emplace_back(id(a), id(b));
  }
  // Bodies that have been put in quarantine since touch nobody.
  std::erase_if(hits, [&](const ContactHit& hit) {
    return world.quarantine.contains(hit.a.index) || world.quarantine.contains(hit.b.index);
  });
  std::sort(hits.begin(), hits.end(), precedes);
  std::ranges::transform(hits, std::back_inserter(events.now), &ContactHit::pair);
  std::sort(events.now.begin(), events.now.end());
  events.now.erase(std::unique(events.now.begin(), events.now.end()), events.now.end());

  events.touched.clear();
  auto active = events.now.begin();
  if (events.reported) {
    for (const std::pair<BodyId, BodyId>& pair : events.before) {
      if (!is_idle(pair)) continue;
      while (active != events.now.end() && *active < pair) events.touched.push_back(*active++);
      // They may have hit earlier in the step, and have fallen asleep since.
      if (active == events.now.end() || *active != pair) events.touched.push_back(pair);
    }
  }
  events.touched.insert(events.touched.end(), active, events.now.end());

  ATL_ASSERT(std::is_sorted(events.touched.begin(), events.touched.end()), events.touched.size());
  ATL_ASSERT(std::adjacent_find(events.touched.begin(), events.touched.end()) == events.touched.end(),
             events.touched.size());
  const double substep = world.clock.dt / step.substeps;
  const auto touch_now = [&](const std::pair<BodyId, BodyId>& pair) {
    const auto first = std::ranges::lower_bound(hits, pair, {}, &ContactHit::pair);
    const auto last = std::ranges::upper_bound(hits, pair, {}, &ContactHit::pair);
    return touch(world, pair, {first, last}, pushes, substep);
  };
  const auto go_on = [&](const std::pair<BodyId, BodyId>& pair) {
    const double min = event_force(world, pair.first, pair.second);
    if (std::isinf(min) || is_idle(pair)) return;
    ContactEvent event = touch_now(pair);
    event.began = false;
    event.persists = true;
    if (event.impulse >= min * substep * world.settings.substeps) events.events.push_back(event);
  };
  auto before = events.before.begin();
  auto now = events.touched.begin();
  while (before != events.before.end() || now != events.touched.end()) {
    if (now == events.touched.end() || (before != events.before.end() && *before < *now)) {
      events.events.push_back({.a = before->first, .b = before->second, .began = false});
      ++before;
    } else if (before == events.before.end() || *now < *before) {
      events.events.push_back(touch_now(*now));
      ++now;
    } else {
      go_on(*now);
      ++before;
      ++now;
    }
  }
}

void watch_joint(Stores& world, std::uint32_t joint) {
  ATL_ASSERT(world.joints.acts[joint] != 0, joint);
  const solver::Joint& j = world.joints.joints[joint];
  const JointId id{joint, world.joints.generation[joint]};
  const JointTable::Limits before = world.joints.limit_before[joint];
  world.joints.limit_before[joint] = j.limit;
  const auto tell = [&](JointEventKind kind) { world.results.joint_events.push_back({id, kind, j.force, j.torque}); };
  if (j.force.norm() > world.joints.def[joint]->break_force ||
      j.torque.norm() > world.joints.def[joint]->break_torque) {
    world.joints.broken[joint] = 1;
    world.joints.enabled[joint] = 0;
    world.joints.update_flags(joint);
    joint_changed(world, joint);
    release_joint(world, joint);
    tell(JointEventKind::Broke);
    return;
  }
  bool reached = false;
  bool left = false;
  for (std::size_t row = 0; row < j.rows; ++row) {
    if (j.limit[row] == before[row]) continue;
    reached |= j.limit[row] != 0;
    left |= before[row] != 0;
  }
  if (left) tell(JointEventKind::LeftLimit);
  if (reached) tell(JointEventKind::ReachedLimit);
}

// s: a body at rest may be as far from the balance of a spring or servo as it goes in this time at
// Settings::sleep_speed: 0.5 mm at the defaults. Robots on servos then fall asleep 0.1 to 0.4 s later than if none kept
// them awake.
constexpr double creep_left = 0.01;

// However slow a motor runs, what it moves is not at rest; what it fails to move may be. The same goes for what a
// damped spring or a servo still takes to its balance, unless it is nearly there. `size`: m, by which angles count.
bool moves(const solver::Law& law, double rate, double size, double sleep_speed) {
  if (law.drives() && law.motor_speed != 0 && rate / law.motor_speed > 0.5) return true;
  return std::abs(rate) * size * creep_time(law) > sleep_speed * creep_left;
}

void keep_driven_awake(Stores& world, std::uint32_t joint) {
  const solver::Joint& j = world.joints.joints[joint];
  const double sleep_speed = world.settings.sleep_speed;
  if (j.is_tendon()) {
    const double rate = tendon_now(j, world.joints.joints.data(), world.bodies).rate;
    if (moves(j.law[0], rate, 1, sleep_speed)) wake_joined_by(world, joint);
    return;
  }
  const auto radius = [&](std::uint32_t body) { return world.records.dynamic[body] ? world.bodies.radius[body] : 0; };
  const double larger = std::max(radius(j.first), radius(j.second));
  const solver::JointFrames frames = frames_of(world, j);
  for (std::size_t row = 0; row < j.rows; ++row) {
    const solver::Law& law = j.law[row];
    if (!law.drives() && creep_time(law) == 0) continue;
    const double rate = joint_row(j, row, frames)
                            .rate(world.bodies.velocity(j.first), world.bodies.angular_velocity(j.first),
                                  world.bodies.velocity(j.second), world.bodies.angular_velocity(j.second));
    const double size = j.coordinate[row] <= solver::Coordinate::Distance ? 1 : larger;
    if (moves(law, rate, size, sleep_speed)) wake_joined_by(world, joint);
  }
}

}  // namespace

void keep_velocities(const Stores& world, std::vector<BodyVelocity>& velocities) {
  velocities.resize(world.bodies.size());
  for (const std::uint32_t body : world.active.in_order()) {
    velocities[body] = {world.bodies.velocity(body), world.bodies.angular_velocity(body)};
  }
}

void add_hits(const Stores& world, const ContactPushes& pushes, bool ends_step, std::vector<ContactHit>& hits) {
  if (pushes.impulse.empty()) return;
  ATL_ASSERT(pushes.impulse.size() == world.cache.contacts.size(), pushes.impulse.size(), world.cache.contacts.size());
  ATL_ASSERT(pushes.velocities.size() == world.bodies.size(), pushes.velocities.size(), world.bodies.size());
  for (const std::uint32_t slot : world.cache.order().slots()) {
    if (pushes.impulse[slot] < 0) continue;
    if (ends_step && touches(world.cache.contacts[slot], world.cache.manifolds[slot])) continue;
    hits.push_back(hit_of(world, slot, pushes));
  }
}

void record_sleep_events(Stores& world) {
  std::vector<SleepEvent>& events = world.results.sleep_events;
  events.clear();
  for (const std::uint32_t body : world.sleeping.news()) {
    if (!world.quarantine.contains(body)) events.push_back({id_of(world, body), world.sleeping.is_asleep(body)});
  }
  world.sleeping.mark_all_reported();
}

void record_contact_events(Stores& world, const ContactPushes& pushes, std::vector<ContactHit>& hits,
                           bool islands_rebuilt, const StepContext& step) {
  const Settings& settings = world.settings;
  StepResults& results = world.results;
  if (settings.contact_events) {
    record_events(world, results.contact_events, pushes, hits, islands_rebuilt, step);
  } else {
    results.contact_events.events.clear();
    if (settings.run_everything) record_events(world, results.unasked_events, pushes, hits, islands_rebuilt, step);
  }
  results.contact_events.reported = settings.contact_events;
  results.unasked_events.reported = settings.run_everything && !settings.contact_events;
}

void record_joint_events(Stores& world, std::span<const solver::JointLink> acting,
                         std::span<const QuarantineFault> broken) {
  const auto is_broken = [&](std::uint32_t body) {
    return std::any_of(broken.begin(), broken.end(),
                       [body](const QuarantineFault& fault) { return fault.first == body; });
  };
  for (const solver::JointLink& link : acting) {
    const solver::Joint& j = world.joints.joints[link.joint];
    if (is_broken(j.first) || is_broken(j.second)) continue;  // what it holds means nothing, and it is to be suspended
    if (world.joints.watched[link.joint]) watch_joint(world, link.joint);
    if (world.settings.sleeping && world.joints.driven[link.joint]) keep_driven_awake(world, link.joint);
  }
  // Islands come in order of their bodies.
  std::stable_sort(world.results.joint_events.begin(), world.results.joint_events.end(),
                   [](const JointEvent& a, const JointEvent& b) { return a.joint < b.joint; });
}

}  // namespace atl
