#include <jobs/stopwatch.h>
#include <jobs/with_continuous.h>
#include <jobs/with_events.h>
#include <jobs/with_joints.h>
#include <jobs/with_sleeping.h>
#include <jobs/with_surfaces.h>

#include <algorithm>

#include "world/world_impl.h"

namespace atl {

StepReport World::Impl::step(double dt) {
  begin_step();
  return advance(dt, settings.substeps, true);
}

void World::Impl::begin_step() {
  ++steps_;
  joint_events_.clear();
}

StepReport World::Impl::advance(double dt, int substeps, bool ends_step) {
  const jobs::Clock::time_point start = jobs::Clock::now();
  dt_ = dt;
  substeps_ = substeps;
  ends_step_ = ends_step;
  report_ = {};
  contact_forces_valid_ = false;
  captured_ = settings.keep_contact_problem;
  const auto run = [this](Phase phase, void (Impl::*body)()) {
    const jobs::Clock::time_point phase_start = jobs::Clock::now();
    (this->*body)();
    report_.phase_ms[static_cast<std::size_t>(phase)] = jobs::ms_since(phase_start);
  };
  run(Phase::Plan, &Impl::plan);                           // who may move, and who is unfit to
  run(Phase::FindPairs, &Impl::find_pairs);                // moved proxies -> new pairs, in id order
  run(Phase::UpdateContacts, &Impl::update_contacts);      // pairs -> manifolds: keep, refresh or ask FCL
  run(Phase::BuildIslands, &Impl::build_islands);          // touching contacts, joints -> islands -> groups; wake
  run(Phase::SolveIslands, &Impl::solve_islands);          // groups are tasks: prepare, substeps, restitution, store
  run(Phase::SweepFastBodies, &Impl::follow_fast_bodies);  // nothing passes through anything
  run(Phase::Finish, &Impl::finish);                       // sleep, checks, report
  last_substep_ = dt / substeps_;
  last_dt_ = dt;
  note_stages();
  report_.ms = jobs::ms_since(start);
  return report_;
}

void World::Impl::plan() {
  quarantine_suspects();
  if (update_active_bodies()) cache.set_active(active_.started(), active_.stopped());
}

bool World::Impl::may_move(std::uint32_t body) const {
  if (bodies.mobility[body] != solver::Mobility::Kinematic) return sleeping.awake[body] != 0;
  return !(bodies.velocity(body).isZero(0) && bodies.angular_velocity(body).isZero(0));
}

// Follows what fell asleep, woke, came, went or got a velocity. Returns whether the active bodies changed.
bool World::Impl::update_active_bodies() {
  may_start_or_stop_.insert(may_start_or_stop_.end(), sleeping.changed.begin(), sleeping.changed.end());
  sleeping.changed.clear();
  const bool changed = active_.update(may_start_or_stop_, [this](std::uint32_t body) { return may_move(body); });
  may_start_or_stop_.clear();
  if (!changed) return false;
  reaches_.resize(bodies.size());
  for (const std::uint32_t body : active_.stopped()) reaches_[body] = {};
  islands_stale_ = true;
  return true;
}

collision::ContactUpdateInput World::Impl::contact_input() const {
  static_assert(sizeof(solver::Mobility) == 1 && static_cast<int>(solver::Mobility::Fixed) == 0);
  return {.colliders = colliders,
          .poses = {bodies.positions.data(), bodies.orientations.data()},
          .dynamic = records.dynamic,
          .mobility = {reinterpret_cast<const std::uint8_t*>(bodies.mobility.data()), bodies.size()},
          .turned = bodies.turned,
          .reaches = reaches_,
          .kernels = *narrowphase_kernels};
}

void World::Impl::update_contacts() {
  note_reaches();
  cache.rises.resize(contents.smooth_surfaces > 0 ? cache.contacts.size() : 0);
  collision::update_contacts(cache, broadphase, contact_input(), arena, contact_update_);
  broadphase.forget_moves();
  const collision::ContactUpdateCounts& counts = contact_update_.counts;
  report_.counts.fcl_calls = counts.fcl_calls;
  report_.counts.fcl_repairs = counts.fcl_repairs;
  report_.counts.kept_manifolds = counts.kept;
  report_.counts.fresh_manifolds = counts.fresh;
  report_.counts.id_matches = counts.id_matches;
  report_.counts.id_misses = counts.id_misses;
  report_.counts.active_bodies = static_cast<std::int64_t>(active_.in_order().size());
  report_.counts.active_contacts = static_cast<std::int64_t>(cache.order.size());
}

// How far bodies get in this step at the speeds they have.
void World::Impl::note_reaches() {
  constexpr std::size_t grain = 1024;
  const std::span<const std::uint32_t> active = active_.in_order();
  if (active.empty()) return;
  reaches_.resize(bodies.size());
  arena.parallel_for(active.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t body : active.subspan(begin, end - begin)) {
      collision::StepReach& reach = reaches_[body];
      const Vector3 shift = dt_ * bodies.velocity(body);
      for (int i = 0; i < 3; ++i) reach.shift[i] = static_cast<float>(shift[i]);
      reach.turn = static_cast<float>(dt_ * bodies.angular_velocity(body).norm() * bodies.radius[body]);
    }
  });
}

// Islands depend on who is awake, what touches and what is joined, so while these stay what they were, the islands do.
void World::Impl::build_islands() {
  if (with_sleeping && sleeping.asleep > 0) wake_touched_sleepers();
  if constexpr (with_joints) {
    update_joint_graph();
    wake_joined_to_moving();
  }
  remove_lost_contacts();
  if (update_active_bodies()) {
    // Contacts of bodies that were just woken count with the features they fell asleep with.
    const std::span<const std::uint32_t> woken = cache.set_active(active_.started(), active_.stopped());
    collision::place_contacts(cache, broadphase, contact_input(), woken, arena);
    contact_update_.add_touching(cache, woken);
  }
  touching_ = contact_update_.touching;
  const bool one_each = settings.tolerance > 0;
  islands_rebuilt_ = islands_stale_ || contact_update_.touching_changed || one_each != one_each_;
  if (islands_rebuilt_) {
    islands_.build(active_.in_order(), sleeping.awake, touching_, joint_graph_.links());
    one_each_ = one_each;
    islands_stale_ = false;
  }
  choose_modes();
  if (with_joints && joints.count > 0) count_joints();
  report_.counts.pairs = static_cast<std::int64_t>(cache.pairs.size());
  report_.counts.contacts = static_cast<std::int64_t>(touching_.size());
  report_.counts.points = contact_update_.counts.points;
}

// Of those that the solve noted as fast.
void World::Impl::follow_fast_bodies() {
  restrain_broken();
  if constexpr (with_continuous) sweep_fast_bodies();
  fast_.for_each([](solver::MovedBodies& of_worker) { of_worker.clear(); });
}

// An active body that touches a sleeping one wakes its island.
void World::Impl::wake_touched_sleepers() {
  for (const solver::TouchingPair& pair : contact_update_.touching) {
    if (active_.contains(pair.first) && sleeping.is_asleep(pair.second)) sleeping.wake(pair.second);
    if (active_.contains(pair.second) && sleeping.is_asleep(pair.first)) sleeping.wake(pair.first);
  }
}

void World::Impl::remove_lost_contacts() {
  if (contact_update_.counts.lost == 0) return;
  std::size_t i = 0;
  cache.remove_if([&](std::uint32_t) { return contact_update_.status[i++] == collision::ContactStatus::Lost; });
}

void World::Impl::finish() {
  aabbs.catch_up(active_.in_order(), motions(), broadphase, arena);
  for (const std::uint32_t body : pushed_) {
    bodies.force(body).setZero();
    bodies.torque(body).setZero();
  }
  pushed_.clear();
  if (ends_step_) note_what_began_and_ended();
  if (with_joints && joints.size() > 0) note_joints();
  if (with_sleeping && settings.sleeping) {
    if (with_surfaces && !bodies.surfaces.empty()) keep_belts_awake();
    sleeping.update(islands_, bodies, settings, dt_);
  }
  StepCounts& counts = report_.counts;
  counts.islands = static_cast<std::int64_t>(islands_.count());
  counts.groups = static_cast<std::int64_t>(groups_.size());
  for (const solver::GroupReport& group : group_reports_) {
    counts.colours = std::max(counts.colours, static_cast<std::int64_t>(group.colours));
    counts.sweeps += group.sweeps;
    for (std::size_t i = 0; i < solver_stage_count; ++i) report_.solver_ms[i] += group.stage_ms[i];
  }
  quarantine_broken();
  counts.asleep = sleeping.asleep;
}

void World::Impl::note_what_began_and_ended() {
  if (with_events && settings.contact_events) {
    note_events(events_);
  } else {
    events_.told.clear();
    if (with_events && settings.run_everything) note_events(unasked_events_);
  }
  events_.noted = settings.contact_events;
  unasked_events_.noted = settings.run_everything && !settings.contact_events;
}

// However slow a belt runs, what it carries is not at rest; what it slips under may be.
void World::Impl::keep_belts_awake() {
  for (const solver::TouchingPair& pair : touching_) {
    const double belt =
        std::max(bodies.surfaces[pair.first].velocity.norm(), bodies.surfaces[pair.second].velocity.norm());
    if (belt == 0) continue;
    for (const std::uint32_t body : {pair.first, pair.second}) {
      if (bodies.velocity(body).norm() > 0.5 * belt) sleeping.rest_time[body] = 0;
    }
  }
}

}  // namespace atl
