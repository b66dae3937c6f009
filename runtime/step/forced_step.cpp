#include "step/forced_step.h"

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

void ForcedStep::make_up(double substep) {
  for (Eigen::Index i = 0; i < now_.force_.cols(); ++i) {
    const auto body = static_cast<std::uint32_t>(i);
    if (!moves_freely(body)) continue;
    const Vector3 force = now_.force_.col(i) - before_.force_.col(i);
    const Vector3 torque = now_.torque_.col(i) - before_.torque_.col(i);
    if (!force.allFinite() || !torque.allFinite()) continue;  // the next substep sees to it
    apply_impulse(world_, body, 0.5 * substep * force, 0.5 * substep * torque);
    world_.quarantine.suspect(body);
    world_.aabbs.mark_dirty(body);
  }
}

// Touched by nothing, nor is what it hangs together with: what rests on something is to rest.
bool ForcedStep::moves_freely(std::uint32_t body) const {
  if (!world_.sleeping.awake[body]) return false;
  const solver::Islands& islands = impl_.pipeline.islands().islands();
  const std::uint32_t island = islands.island_of(body);
  return island == solver::Islands::none || islands.contact_count(island) == 0;
}

}  // namespace atl
