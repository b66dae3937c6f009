#include "step/pipeline.h"

#include <features/with_continuous.h>
#include <features/with_joints.h>
#include <features/with_surfaces.h>
#include <jobs/assert.h>
#include <jobs/scratch.h>
#include <jobs/stopwatch.h>

#include <algorithm>
#include <utility>

#include "step/events.h"
#include "step/sensors.h"
#include "step/validate.h"
#include "world/bodies.h"
#include "world/colliders.h"

namespace atl {
namespace {

void report_quarantined(std::span<const QuarantineFault> faults, StepReport& report) {
  report.quarantined += static_cast<std::int64_t>(faults.size());
  for (const auto& [body, reason] : faults) {
    const auto index = static_cast<std::int64_t>(body);
    if (report.first_quarantined < 0 || index < report.first_quarantined) report.first_quarantined = index;
  }
}

// However slow a belt or a turntable runs, what it carries is not at rest; what it slips under may be.
void keep_belts_awake(Stores& world, std::span<const solver::TouchingPair> touching) {
  const solver::BodyTable& bodies = world.bodies;
  const auto is_carried = [](const auto& velocity, double by) { return by > 0 && velocity.norm() > 0.5 * by; };
  for (const solver::TouchingPair& pair : touching) {
    if (bodies.surfaces[pair.first].motion.is_zero() && bodies.surfaces[pair.second].motion.is_zero()) continue;
    const collision::ContactManifold& manifold = world.cache.manifolds[pair.slot];
    const auto belt = [&](std::uint32_t body, const float* anchor) {
      return solver::surface_velocity_at(bodies, body, Eigen::Map<const Eigen::Vector3f>(anchor).cast<double>()).norm();
    };
    const double runs = std::max(belt(pair.first, manifold.anchor_first), belt(pair.second, manifold.anchor_second));
    const double turns =
        std::max(solver::surface_spin(bodies, pair.first).norm(), solver::surface_spin(bodies, pair.second).norm());
    for (const std::uint32_t body : {pair.first, pair.second}) {
      const bool carried = is_carried(bodies.velocity(body), runs) || is_carried(bodies.angular_velocity(body), turns);
      if (carried) world.sleeping.rest_time[body] = 0;
    }
  }
}

// The same of what a modifier makes run.
void keep_carried_awake(Stores& world, const ContactPhase& contacts) {
  const solver::AddedSlip* slips = contacts.added_slips();
  if (slips == nullptr) return;
  for (const solver::TouchingPair& pair : contacts.touching()) {
    const Vector3 slip = Eigen::Map<const Eigen::Vector3f>(slips[pair.slot].velocity).cast<double>();
    if (slip.isZero(0)) continue;
    for (const std::uint32_t body : {pair.first, pair.second}) {
      if (world.bodies.velocity(body).norm() > 0.5 * slip.norm()) world.sleeping.rest_time[body] = 0;
    }
  }
}

void limit_speeds(Stores& world) {
  const auto limit = [](auto velocity, const std::optional<double>& max) {
    const double speed = velocity.norm();
    if (max && speed > *max) velocity *= *max / speed;
  };
  for (const std::uint32_t body : world.active.in_order()) {
    const BodyConstants& constants = *world.records.constants[body];
    limit(world.bodies.velocity(body), constants.max_speed);
    limit(world.bodies.angular_velocity(body), constants.max_angular_speed);
  }
}

}  // namespace

void StepMemory::begin(int threads) {
  moved.reach(threads);
  moved.for_each([](solver::MovedBodies& of_worker) { of_worker.clear(); });
  continuous.reach(threads);
}

void StepPipeline::run(Stores& world, const StepContext& step) {
  ATL_ASSERT(world.clock.dt > 0 && step.substeps >= 1, world.clock.dt, step.substeps);
  if (step.rules != nullptr) step.rules->begin_substep();
  const jobs::Borrowed<StepMemory> memory;
  memory->begin(step.arena.threads());
  // A phase begins as the one before ends: to ask for the time takes as long as some phases of a small world.
  jobs::Clock::time_point begin = jobs::Clock::now();
  const auto run = [&](Phase phase, const auto& body) {
    body();
    const jobs::Clock::time_point end = jobs::Clock::now();
    step.report.phase_ms[static_cast<std::size_t>(phase)] = jobs::ms_between(begin, end);
    begin = end;
  };
  run(Phase::Plan, [&] { plan(world, step); });                        // who may move, and who is unfit to
  run(Phase::FindPairs, [&] { find_pairs(world, step); });             // moved AABBs -> new pairs, in id order
  run(Phase::UpdateContacts, [&] { contacts_.update(world, step); });  // pairs -> manifolds: keep, refresh, ask FCL
  run(Phase::BuildIslands, [&] { build_islands(world, step); });       // touching, joints -> islands -> groups; wake
  run(Phase::SolveIslands, [&] { solve_islands(world, step, *memory); });          // groups are tasks: substeps, store
  run(Phase::SweepFastBodies, [&] { follow_fast_bodies(world, step, *memory); });  // nothing passes through anything
  run(Phase::Finish, [&] { finish(world, step); });                                // events, sleep, checks, report
}

void StepPipeline::plan(Stores& world, const StepContext& step) {
  report_quarantined(quarantine_suspects(world), step.report);
  update_active_bodies(world);
  if (world.contents.with_speed_limit > 0) limit_speeds(world);
}

void StepPipeline::build_islands(Stores& world, const StepContext& step) {
  islands_.build(world, step, contacts_);
  if (contacts_.kinds_changed()) solve_.recolour();
  solve_.choose_modes(world, step, islands_);
}

void StepPipeline::solve_islands(Stores& world, const StepContext& step, StepMemory& memory) {
  if constexpr (with_continuous) memory.continuous.watch_surface_contacts(world, contacts_);
  if (finds_contact_events(world.settings)) keep_velocities(world, velocities_);
  solve_.solve(world, step, contacts_.added_slips(), islands_, memory.moved);
  add_hits(world, {solve_.pushed(), velocities_}, step.ends_step, hits_);
  if (world.settings.target.is_set()) solve_.record_errors(world, step, contacts_.touching(), islands_);
}

void StepPipeline::follow_fast_bodies(Stores& world, const StepContext& step, StepMemory& memory) {
  restrain_broken(world, memory.moved, broken_);
  if constexpr (with_continuous) memory.continuous.sweep(world, step, contacts_, islands_, memory.moved);
}

void StepPipeline::finish(Stores& world, const StepContext& step) {
  world.aabbs.catch_up(world.active.in_order(), motions(world), world.broadphase, step.arena);
  if (world.contents.with_speed_limit > 0) limit_speeds(world);
  clear_forces(world);
  rebuilt_ |= islands_.rebuilt();
  if (step.ends_step) {
    record_contact_events(world, {solve_.pushed(), velocities_}, hits_, std::exchange(rebuilt_, false), step);
    record_sensor_events(world, step.arena);
  }
  if (with_joints && world.joints.size() > 0) record_joint_events(world, islands_.acting_joints(), broken_);
  if (world.settings.sleeping) {
    if (with_surfaces && !world.bodies.surfaces.empty()) keep_belts_awake(world, contacts_.touching());
    keep_carried_awake(world, contacts_);
    world.sleeping.update(islands_.islands(), world.bodies, world.settings, world.clock.dt);
  }
  if (step.ends_step) record_sleep_events(world);
  StepCounts& counts = step.report.counts;
  if (step.rules != nullptr) {
    counts.filtered_pairs = step.rules->asked_pairs();
    counts.asked_contacts = step.rules->asked_contacts();
  }
  counts.islands = static_cast<std::int64_t>(islands_.islands().count());
  counts.groups = static_cast<std::int64_t>(solve_.groups().size());
  for (const solver::GroupReport& group : solve_.group_reports()) {
    counts.colours = std::max(counts.colours, static_cast<std::int64_t>(group.colours));
    counts.sweeps += group.sweeps;
    for (std::size_t i = 0; i < solver_phase_count; ++i) step.report.solver_ms[i] += group.phase_ms[i];
  }
  // Now that nothing asks for the step's islands any more.
  for (const auto& [body, reason] : broken_) put_in_quarantine(world, body, reason);
  if (!broken_.empty()) world.results.captured = false;
  report_quarantined(broken_, step.report);
  counts.asleep = world.sleeping.asleep;
  if constexpr (jobs::with_asserts) validate(world);
}

}  // namespace atl
