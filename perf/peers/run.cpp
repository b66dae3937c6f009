#include "run.h"

#include <atoll/error_meter.h>
#include <time.h>

#include <chrono>

namespace peer {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double cpu_seconds() {
  timespec now = {};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool is_finite(const atl::BodyState& body) {
  return body.pose.position.allFinite() && body.pose.orientation.coeffs().allFinite() && body.velocity.allFinite() &&
         body.angular_velocity.allFinite();
}

std::vector<atl::BodyState> finite_states(const Simulation& simulation, int step) {
  std::vector<atl::BodyState> states = simulation.states();
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (is_finite(states[i])) continue;
    throw NonFinite("body " + std::to_string(i) + " is not finite after step " + std::to_string(step));
  }
  return states;
}

}  // namespace

SteppedRun run_stepped(const Engine& engine, const atl::Scene& scene, const Setting& setting) {
  SteppedRun run;
  std::unique_ptr<Simulation> simulation;
  do {
    simulation.reset();
    simulation = engine.load(scene, setting);
    run.ms.clear();
    for (int i = 0; i < scene.steps; ++i) {
      const Clock::time_point start = Clock::now();
      simulation->step();
      run.ms.push_back(1e3 * seconds_since(start));
    }
  } while (simulation->started_over());
  run.states = finite_states(*simulation, scene.steps);
  atl::ErrorMeter meter(scene, atl::ErrorMeter::Follow::End);
  meter.observe(scene.steps * scene.dt, run.states);
  run.outcome = {meter.errors(), meter.fell()};
  return run;
}

Outcome run_observed(const Engine& engine, const atl::Scene& scene, const Setting& setting) {
  const std::unique_ptr<Simulation> simulation = engine.load(scene, setting);
  atl::ErrorMeter meter(scene);
  if (meter.needs_loads()) simulation->keep_loads();
  for (int step = 1; step <= scene.steps; ++step) {
    simulation->step();
    meter.observe(step * scene.dt, finite_states(*simulation, step),
                  meter.needs_loads() ? simulation->loads() : std::vector<atl::ContactLoad>());
  }
  return {meter.errors(), meter.fell()};
}

TimedRuns run_timed(const Engine& engine, const atl::Scene& scene, const Setting& setting, double seconds) {
  TimedRuns timed;
  while (timed.runs == 0 || timed.cpu < seconds) {
    const std::unique_ptr<Simulation> simulation = engine.load(scene, setting);
    const double cpu = cpu_seconds();
    const Clock::time_point start = Clock::now();
    for (int i = 0; i < scene.steps; ++i) simulation->step();
    const double cpu_taken = cpu_seconds() - cpu, wall_taken = seconds_since(start);
    finite_states(*simulation, scene.steps);
    if (simulation->started_over()) continue;
    timed.cpu += cpu_taken;
    timed.wall += wall_taken;
    ++timed.runs;
  }
  return timed;
}

}  // namespace peer
