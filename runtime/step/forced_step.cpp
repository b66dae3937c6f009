#include "step/forced_step.h"

#include <features/with_joints.h>
#include <features/with_recording.h>
#include <jobs/assert.h>

#include <utility>

#include "state/recorder.h"
#include "world/bodies.h"
#include "world/refuse.h"

namespace atl {
namespace {

// The counts of what was done add up; those of what there is are the last ones.
void add(StepReport& sum, const StepReport& last) {
  const StepReport before = std::exchange(sum, last);
  sum.ms += before.ms;
  for (std::size_t i = 0; i < phase_count; ++i) sum.phase_ms[i] += before.phase_ms[i];
  for (std::size_t i = 0; i < solver_phase_count; ++i) sum.solver_ms[i] += before.solver_ms[i];
  for (std::int64_t StepCounts::*count :
       {&StepCounts::aabb_updates, &StepCounts::filtered_pairs, &StepCounts::newton_iterations,
        &StepCounts::unsolved_islands, &StepCounts::discarded_iterations, &StepCounts::body_substeps,
        &StepCounts::recycled_manifolds, &StepCounts::recomputed_manifolds, &StepCounts::fcl_calls,
        &StepCounts::fcl_repairs, &StepCounts::id_matches, &StepCounts::id_misses, &StepCounts::sweeps,
        &StepCounts::swept, &StepCounts::stopped}) {
    sum.counts.*count += before.counts.*count;
  }
  sum.quarantined += before.quarantined;
  if (before.first_quarantined >= 0 &&
      (last.first_quarantined < 0 || before.first_quarantined < last.first_quarantined)) {
    sum.first_quarantined = before.first_quarantined;
  }
  for (std::size_t i = 0; i < feature_count; ++i) {
    FeatureReport& feature = sum.features[i];
    const double ms = feature.ms + before.features[i].ms;
    if (before.features[i].items > feature.items) feature = before.features[i];
    feature.ms = ms;
  }
}

}  // namespace

void Forces::add(BodyId id, const Vector3& force, const Vector3& torque) {
  check_finite("Forces::add: force", force);
  check_finite("Forces::add: torque", torque);
  if (!world_.contains(id)) refuse_stale("Forces::add", id);
  force_.col(id.index) += force;
  torque_.col(id.index) += torque;
}

void Forces::add_at(BodyId id, const Vector3& force, const Vector3& point) {
  check_finite("Forces::add_at: force", force);
  check_finite("Forces::add_at: point", point);
  if (!world_.contains(id)) refuse_stale("Forces::add_at", id);
  const Vector3 arm = point - world_.centre_of_mass(id);
  force_.col(id.index) += force;
  torque_.col(id.index) += arm.cross(force);
}

ForcedStep::ForcedStep(World& world, const ForceLaw& law, double dt)
    : impl_(*world.impl_),
      world_(impl_.stores),
      law_(law),
      dt_(dt),
      now_(world, static_cast<Eigen::Index>(world_.bodies.size())),
      before_(world, static_cast<Eigen::Index>(world_.bodies.size())) {
  for (const std::uint32_t body : world_.changes.pushed) {
    steady_.push_back({body, world_.bodies.force(body), world_.bodies.torque(body)});
  }
}

StepReport ForcedStep::run() {
  const int substeps = world_.settings.substeps;
  const double h = dt_ / substeps;
  StepReport report;
  impl_.begin_step();
  for (int i = 0; i < substeps; ++i) {
    ask(i * h);
    impl_.step_guard.change([&] {
      if (i > 0) make_up(h);
      apply(i > 0);
      add(report, impl_.advance(h, 1, i + 1 == substeps));
    });
  }
  ask(dt_);
  impl_.step_guard.change([&] { make_up(h); });
  return report;
}

void ForcedStep::ask(double time) {
  std::swap(now_.force_, before_.force_);
  std::swap(now_.torque_, before_.torque_);
  now_.force_.setZero();
  now_.torque_.setZero();
  now_.time_ = time;
  impl_.asking = "a force law";
  try {
    law_(now_);
  } catch (...) {
    impl_.asking = nullptr;
    record(false);
    throw;
  }
  impl_.asking = nullptr;
  record(true);
}

void ForcedStep::record([[maybe_unused]] bool given) {
  if constexpr (with_recording) {
    if (!impl_.recorder) return;
    if (given) {
      impl_.recorder->record_forces(now_.forces(), now_.torques());
    } else {
      impl_.recorder->record_no_forces();
    }
  }
}

void ForcedStep::apply(bool again) {
  ATL_ASSERT(static_cast<std::size_t>(now_.force_.cols()) == world_.bodies.size(), now_.force_.cols(),
             world_.bodies.size());
  if (again) {
    for (const Applied& steady : steady_) apply_force(world_, steady.body, steady.force, steady.torque);
  }
  for (Eigen::Index i = 0; i < now_.force_.cols(); ++i) {
    const Vector3 force = now_.force_.col(i), torque = now_.torque_.col(i);
    if (force.isZero(0) && torque.isZero(0)) continue;
    const auto body = static_cast<std::uint32_t>(i);
    if (world_.records.dynamic[body]) apply_force(world_, awaken(world_, body), force, torque);
  }
}

// Gives half of the change of forces. Islands with contacts are left out, since bodies that rest in them are to rest.
void ForcedStep::make_up(double substep) {
  before_.force_ = now_.force_ - before_.force_;
  before_.torque_ = now_.torque_ - before_.torque_;
  make_up_free(substep);
  if constexpr (with_joints) make_up_joined(substep);
}

void ForcedStep::make_up_free(double substep) {
  for (const std::uint32_t body : impl_.pipeline.islands().islands().free_bodies()) {
    if (!changes({&body, 1})) continue;
    apply_impulse(world_, body, 0.5 * substep * before_.force_.col(body), 0.5 * substep * before_.torque_.col(body));
    world_.quarantine.suspect(body);
    world_.aabbs.mark_dirty(body);
  }
}

// Gives joined bodies the change as their joints answer to it, swept joints too. Components with too many loops to be
// solved at once are left out.
void ForcedStep::make_up_joined(double substep) {
  IslandPhase& phase = impl_.pipeline.islands();
  const solver::Islands& islands = phase.islands();
  solver::FastBodies none(0);
  const solver::SolveInput input{.islands = islands,
                                 .bodies = world_.bodies,
                                 .manifolds = nullptr,
                                 .gravity = world_.gravity,
                                 .dt = substep,
                                 .settings = {.substeps = 1},
                                 .kernels = *impl_.kernels,
                                 .bounds = world_.aabbs.bounds,
                                 .fast = none,
                                 .joints = world_.joints.joints.data(),
                                 .joint_graph = &phase.joint_graph(),
                                 .joint_systems = &phase.joint_systems()};
  std::vector<solver::DirectJoints*> joined;
  for (const Applied& steady : steady_) apply_force(world_, steady.body, steady.force, steady.torque);
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const std::span<const std::uint32_t> bodies = islands.bodies(island, island + 1);
    if (islands.contact_count(island) > 0 || !changes(bodies)) continue;
    const std::uint32_t joint = islands.joints(island, island + 1).front().joint;
    solver::DirectJoints* joints = phase.joint_systems().for_impacts(input, phase.joint_graph().component_of(joint));
    if (joints == nullptr) continue;
    joined.push_back(joints);
    for (const std::uint32_t body : bodies) {
      apply_force(world_, body, now_.force_.col(body) - before_.force_.col(body),
                  now_.torque_.col(body) - before_.torque_.col(body));
      world_.quarantine.suspect(body);
      world_.aabbs.mark_dirty(body);
    }
  }
  impl_.arena.parallel_for(joined.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      static_cast<void>(joined[i]->follow_forces(input, {before_.force_.data(), before_.torque_.data()}));
    }
  });
  clear_forces(world_);
}

// True if the forces have changed on bodies of which nothing is asleep or in quarantine; the next substep sees to what
// is not finite.
bool ForcedStep::changes(std::span<const std::uint32_t> bodies) const {
  bool any = false;
  for (const std::uint32_t body : bodies) {
    if (!world_.sleeping.awake[body] || world_.quarantine.contains(body)) return false;
    const auto force = before_.force_.col(body), torque = before_.torque_.col(body);
    if (!force.allFinite() || !torque.allFinite()) return false;
    any |= !force.isZero(0) || !torque.isZero(0);
  }
  return any;
}

}  // namespace atl
