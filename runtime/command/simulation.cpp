#include "simulation.h"

#include <atoll/error_meter.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "checks/tradeoff/residual_meter.h"
#include "failure.h"
#include "interrupt.h"
#include "progress.h"
#include "view/watcher.h"

namespace atl::command {
namespace {

StepTimes step_times(std::vector<double> ms) {
  const auto longest = static_cast<int>(std::max_element(ms.begin(), ms.end()) - ms.begin()) + 1;
  std::sort(ms.begin(), ms.end());
  const std::size_t n = ms.size();
  const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(n)));
  return {.mean = std::accumulate(ms.begin(), ms.end(), 0.0) / static_cast<double>(n),
          .median = (ms[(n - 1) / 2] + ms[n / 2]) / 2,
          .p99 = ms[rank - 1],
          .max = ms.back(),
          .longest = longest};
}

std::size_t place_of(BodyId id, const std::vector<BodyId>& ids) {
  return static_cast<std::size_t>(std::find(ids.begin(), ids.end(), id) - ids.begin());
}

}  // namespace

void TargetTally::add(const StepCounts& counts) {
  bodies += counts.island_bodies;
  body_substeps += counts.body_substeps;
  max_substeps = std::max(max_substeps, counts.max_substeps);
  missed_steps += counts.missed_targets > 0;
  missed_targets += counts.missed_targets;
}

double TargetTally::mean_substeps() const {
  return bodies > 0 ? static_cast<double>(body_substeps) / static_cast<double>(bodies) : 0;
}

World make_world(const Scene& scene, int threads) {
  try {
    return World({.gravity = scene.gravity, .threads = threads, .settings = scene.settings});
  } catch (const Error& error) {
    throw Failure(Status::Usage, error.what());
  }
}

RunResult simulate(const Scene& scene, World& world, const std::vector<BodyId>& ids, const Keep& keep) {
  RunResult result;
  Progress progress(scene.steps);
  ErrorMeter meter(scene, keep.errors ? ErrorMeter::Follow::Run : ErrorMeter::Follow::End);
  tradeoff::ResidualMeter residual;
  const auto observe = [&](int step) {
    meter.observe(step * scene.dt, body_states(world, ids),
                  meter.needs_loads() ? contact_loads(world, ids) : std::vector<ContactLoad>());
  };
  for (view::Watcher* watcher : keep.watchers) watcher->begin(world);
  std::vector<double> ms;
  for (int step = 1; step <= scene.steps; ++step) {
    if (keep.final_state) result.final_state.copy(world);
    apply_forces(scene, world, ids);
    result.last = world.step(scene.dt);
    result.steps = step;
    ms.push_back(result.last.ms);
    for (int phase = 0; phase < phase_count; ++phase) result.phase_ms[phase] += result.last.phase_ms[phase];
    for (std::size_t phase = 0; phase < solver_phase_count; ++phase)
      result.solver_ms[phase] += result.last.solver_ms[phase];
    result.target.add(result.last.counts);
    result.points += static_cast<double>(result.last.counts.points);
    for (view::Watcher* watcher : keep.watchers) watcher->add(world, result.last, scene.dt);
    if (result.last.quarantined > 0 && !keep.going) {
      result.broken = true;
      break;
    }
    if (keep.errors) residual.observe(world);
    result.interrupted = step < scene.steps && interrupted();
    if (keep.errors || step == scene.steps || result.interrupted) observe(step);
    if (result.interrupted) break;
    progress.update(step);
  }
  const auto steps = static_cast<double>(ms.size());
  for (const SolverChoice& island : world.solver_choices()) {
    result.solver_choices.push_back({place_of(island.lowest, ids), island});
  }
  for (const MissedTarget& island : world.missed_targets()) {
    result.missed_targets.push_back({place_of(island.lowest, ids), island});
  }
  for (double& phase : result.phase_ms) phase /= steps;
  for (double& phase : result.solver_ms) phase /= steps;
  result.points /= steps;
  result.step_times = step_times(std::move(ms));
  for (const Quarantined& out : world.quarantined()) result.lost.push_back({out.step, place_of(out.id, ids), out.why});
  if (result.broken) return result;

  if (keep.final_state) result.final_state.copy(world);
  result.hash = world.state_hash();
  result.errors = meter.errors();
  if (keep.errors) {
    result.errors.push_back({"contact_residual", residual.last(), ""});
    result.errors.push_back({"contact_residual_max", residual.max(), ""});
  }
  return result;
}

}  // namespace atl::command
