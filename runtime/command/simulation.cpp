#include "simulation.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "progress.h"

namespace atl::command {
namespace {

StepTimes step_times(std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  const std::size_t n = ms.size();
  const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(n)));
  return {.mean = std::accumulate(ms.begin(), ms.end(), 0.0) / static_cast<double>(n),
          .median = (ms[(n - 1) / 2] + ms[n / 2]) / 2,
          .p99 = ms[rank - 1],
          .max = ms.back()};
}

std::size_t place_of(std::int64_t index, const std::vector<BodyId>& ids) {
  const auto found = std::find_if(ids.begin(), ids.end(), [=](BodyId id) { return id.index == index; });
  return static_cast<std::size_t>(found - ids.begin());
}

// Steps until the end or until a body is no longer finite; fills in times, last report and state.
void run_steps(const Scene& scene, World& world, const std::vector<BodyId>& ids, bool keep_state, RunResult& result) {
  Progress progress(scene.steps);
  std::vector<double> ms;
  for (int step = 1; step <= scene.steps && !result.non_finite; ++step) {
    if (keep_state) result.final_state.copy(world);
    result.last = world.step(scene.dt);
    ms.push_back(result.last.ms);
    for (int phase = 0; phase < phase_count; ++phase) result.phase_ms[phase] += result.last.phase_ms[phase];
    if (result.last.first_non_finite_body >= 0) {
      result.non_finite = NonFinite{step, place_of(result.last.first_non_finite_body, ids)};
    }
    progress.update(step);
  }
  for (double& phase : result.phase_ms) phase /= static_cast<double>(ms.size());
  result.step_times = step_times(std::move(ms));
}

}  // namespace

RunResult simulate(const Scene& scene, World& world, const std::vector<BodyId>& ids, bool keep_state) {
  RunResult result;
  run_steps(scene, world, ids, keep_state, result);
  if (result.non_finite) return result;

  if (keep_state) result.final_state.copy(world);
  result.hash = world.state_hash();
  const std::vector<PlacedShape> shapes = placed_shapes(scene, world, ids);
  result.penetration = measure_penetration(shapes);
  if (scene.starts_at_rest) {
    // Without gravity no direction is down; the scenes' own up is as good as any.
    const double g = scene.gravity.norm();
    const Vector3 up = g > 0 ? Vector3(-scene.gravity / g) : Vector3(0, 0, 1);
    result.rest = measure_rest(placed_shapes(scene), shapes, up);
  }
  return result;
}

}  // namespace atl::command
