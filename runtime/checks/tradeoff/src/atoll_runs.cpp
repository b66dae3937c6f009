#include "atoll_runs.h"

#include <atoll/error_meter.h>

#include <chrono>
#include <ctime>

#include "checks/tradeoff/residual_meter.h"
#include "state/hex.h"

namespace atl::tradeoff {
namespace {

struct Spent {
  double cpu = 0;   ///< s
  double wall = 0;  ///< s
};

// One run; returns the state hash.
std::uint64_t time_run(const ScenePlan& plan, const Configuration& configuration, Spent& spent, const Stop& stop) {
  using Clock = std::chrono::steady_clock;
  World world = make_world(plan, configuration, false);
  const std::vector<BodyId> ids = build_scene(plan.scene, world);
  const int steps = plan.steps(configuration);
  const Clock::time_point start = Clock::now();
  const double cpu_start = process_time();
  for (int step = 0; step < steps; ++step) {
    stop_if_asked(stop);
    apply_forces(plan.scene, world, ids);
    world.step(configuration.dt);
  }
  spent.cpu += process_time() - cpu_start;
  spent.wall += std::chrono::duration<double>(Clock::now() - start).count();
  return world.state_hash();
}

}  // namespace

World make_world(const ScenePlan& plan, const Configuration& configuration, bool diagnostics) {
  WorldDef def = {.gravity = plan.scene.gravity, .threads = configuration.threads, .settings = configuration.settings};
  def.settings.keep_contact_problem = diagnostics;
  try {
    return World(def);
  } catch (const Error& error) {
    throw SceneError(plan.scene.name + ": " + error.what());
  }
}

double process_time() {
  timespec now = {};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Record describe(const ScenePlan& plan, const Configuration& configuration) {
  const Configuration& scenes_own = plan.configurations.front();
  Record record = {.engine = "Atoll", .label = label_of(configuration, scenes_own)};
  record.is_default = same_place(configuration, scenes_own);
  record.same_bits = !record.is_default;
  for (const Axis& axis : axes()) {
    record.options.emplace_back(axis.name, axis.value(configuration));
    if (axis.changes_result && axis.value(configuration) != axis.value(scenes_own)) record.same_bits = false;
  }
  record.threads = configuration.threads;
  record.steps = plan.steps(configuration);
  record.dt = configuration.dt;
  return record;
}

void measure_errors(const ScenePlan& plan, const Configuration& configuration, Record& record, const Stop& stop) {
  World world = make_world(plan, configuration, true);
  const std::vector<BodyId> ids = build_scene(plan.scene, world);
  ErrorMeter meter(plan.scene);
  ResidualMeter residual;
  for (int step = 1; step <= record.steps; ++step) {
    stop_if_asked(stop);
    apply_forces(plan.scene, world, ids);
    if (world.step(configuration.dt).first_quarantined >= 0) {
      record.outcome = Outcome::NonFinite;
      record.why = "became non-finite in step " + std::to_string(step) + " of " + std::to_string(record.steps);
      return;
    }
    residual.observe(world);
    meter.observe(step * configuration.dt, body_states(world, ids),
                  meter.needs_loads() ? contact_loads(world, ids) : std::vector<ContactLoad>());
  }
  record.errors = meter.errors();
  record.errors.push_back({"contact_residual_median", residual.median(), ""});
  record.errors.push_back({"contact_residual_max", residual.max(), ""});
  record.hash = world.state_hash();
  record.touching = touching_share(plan.scene, world, ids);
  if (meter.fell()) {
    record.outcome = Outcome::Fell;
    record.why = "fell: a body left its place for good";
  }
  record.judge_joints();
}

void measure_time(const ScenePlan& plan, const Configuration& configuration, double min_time, Record& record,
                  const Stop& stop) {
  Spent spent;
  int runs = 0;
  do {
    const std::uint64_t hash = time_run(plan, configuration, spent, stop);
    if (hash != record.hash) {
      throw OtherBits(plan.scene.name + ", " + record.label +
                      ": the timed run ended in another state than the observed one, " + hash_text(hash) + " against " +
                      hash_text(record.hash.value_or(0)));
    }
    ++runs;
  } while (spent.wall < min_time);
  record.cpu.add(spent.cpu / (runs * record.steps * record.dt));
  record.wall.add(1000 * spent.wall / (static_cast<double>(runs) * record.steps));
}

}  // namespace atl::tradeoff
