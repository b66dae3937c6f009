#include <atoll/world.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulate.h"

namespace atl::stability {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
}

bool is_good(const BodyState& state) {
  constexpr double rounding = 1e-6;
  return state.pose.position.allFinite() && state.velocity.allFinite() && state.angular_velocity.allFinite() &&
         std::abs(state.pose.orientation.norm() - 1) < rounding;
}

}  // namespace

Simulated simulate(const Scene& scene, int steps) {
  World world({.gravity = scene.gravity, .threads = 1, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  Simulated run{.history = {.scene = scene, .states = {body_states(world, ids)}}};
  for (int step = 1; step <= steps; ++step) {
    apply_forces(scene, world, ids);
    run.ms.push_back(world.step(scene.dt).ms);
    run.history.states.push_back(body_states(world, ids));
    const std::vector<BodyState>& states = run.history.states.back();
    auto bad = std::find_if_not(states.begin(), states.end(), is_good);
    for (std::size_t i = 0; i < ids.size() && bad == states.end(); ++i) {
      if (world.is_quarantined(ids[i])) bad = states.begin() + static_cast<std::ptrdiff_t>(i);
    }
    if (bad != states.end()) {
      run.bad_state = BadState{step, static_cast<std::size_t>(bad - states.begin())};
      break;
    }
  }
  return run;
}

double Finding::margin() const { return value > 0 ? limit / value : std::numeric_limits<double>::infinity(); }

bool CaseResult::failed() const {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return !finding.holds() && finding.known_failure.empty(); });
}

CaseResult run_case(const StabilityCase& test) {
  const Scene scene = test.build();
  const Simulated run = simulate(scene, test.steps);
  CaseResult result{.findings = {}, .ms_per_step = median(run.ms), .bad_state = run.bad_state};
  if (result.ms_per_step > 0) result.worst_step = *std::max_element(run.ms.begin(), run.ms.end()) / result.ms_per_step;
  for (const Criterion& criterion : test.criteria) {
    const double value = run.bad_state ? std::numeric_limits<double>::infinity() : criterion.measure(run.history);
    result.findings.push_back({criterion.name, criterion.unit, criterion.limit, value, criterion.known_failure});
  }
  return result;
}

}  // namespace atl::stability
