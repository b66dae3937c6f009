#include "checks/tradeoff/frontier.h"

#include <atoll/scene.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "atoll_runs.h"
#include "checks/tradeoff/grid.h"

namespace atl::tradeoff {
namespace {

constexpr double min_time = 0.02;  // s of stepping, for a time

std::string text(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

PeerRun run_of(const std::string& scene, int steps, double dt = 1.0 / 60) {
  return {.scene = scene, .steps = steps, .dt = dt};
}

bool survives(const Record& record, const Ladder& ladder) {
  return record.outcome == Outcome::Done &&
         std::all_of(ladder.limits.begin(), ladder.limits.end(), [&](const Ladder::Limit& limit) {
           return std::abs(record.error(limit.measure).value_or(0)) <= limit.max;
         });
}

// `measure(run)` gives a record with errors, `time(run, record)` adds a time to it.
template <typename Measure, typename Time>
void climb_with(const Ladder& ladder, const Measure& measure, const Time& time, Reach& reach) {
  std::optional<Record> last;
  for (const double rung : ladder.rungs) {
    Record record = measure(ladder.run(rung));
    if (!survives(record, ladder)) break;
    reach.rung = rung;
    last = std::move(record);
  }
  if (!last) return;
  time(ladder.run(*reach.rung), *last);
  if (last->wall.count() > 0) reach.ms_per_step = last->wall.median();
}

ScenePlan plan_of(const PeerRun& run, int substeps) {
  ScenePlan plan = {.address = run.scene, .scene = load_scene(run.scene, run.seed)};
  plan.scene.steps = run.steps;
  plan.scene.dt = run.dt;
  Configuration configuration = {.settings = plan.scene.settings, .dt = run.dt};
  configuration.settings.substeps = substeps;
  plan.configurations = {configuration};
  return plan;
}

Reach climb_with_atoll(const Ladder& ladder, int substeps, const Stop& stop) {
  Reach reach = {.engine = "Atoll", .substeps = substeps, .is_default = substeps == Settings{}.substeps, .rung = {}};
  const auto measure = [&](const PeerRun& run) {
    const ScenePlan plan = plan_of(run, substeps);
    Record record = describe(plan, plan.configurations.front());
    measure_errors(plan, plan.configurations.front(), record, stop);
    return record;
  };
  const auto time = [&](const PeerRun& run, Record& record) {
    const ScenePlan plan = plan_of(run, substeps);
    measure_time(plan, plan.configurations.front(), min_time, record, stop);
  };
  climb_with(ladder, measure, time, reach);
  return reach;
}

Reach climb_with_peer(const Ladder& ladder, const PeerDriver& driver, int substeps) {
  Reach reach = {.engine = driver.engine(), .substeps = substeps, .rung = {}};
  const PeerSetting setting = {.label = text(substeps) + " substeps", .options = {"--substeps", text(substeps)}};
  const auto measure = [&](const PeerRun& run) {
    Record record = driver.describe(setting, run);
    driver.measure_errors(setting, run, record);
    return record;
  };
  const auto time = [&](const PeerRun& run, Record& record) { driver.measure_time(setting, run, min_time, record); };
  climb_with(ladder, measure, time, reach);
  return reach;
}

}  // namespace

std::vector<Ladder> stiff_ladders() {
  const std::vector<Ladder::Limit> stands = {{"drift_max", 0.01}, {"sink_max", 0.1}};
  const std::string stands_words = "drifts by less than 10 mm and sinks by less than 100 mm in 10 s";
  const std::vector<Ladder::Limit> holds = {{"joint_drift_max", 0.01}};
  const std::string holds_words = "ends with joints less than 10 mm apart";
  return {
      {.name = "boxes of a tower",
       .scene = "stack",
       .survives = stands_words,
       .rungs = {5, 10, 20, 50, 100, 200, 400},
       .run = [](double boxes) { return run_of("stack:height=" + text(boxes), 600); },
       .limits = stands},
      {.name = "density of a tower's top box over that of the nine below",
       .scene = "stack",
       .survives = stands_words,
       .rungs = {1, 10, 100, 1e3, 1e4, 1e5, 1e6},
       .run = [](double ratio) { return run_of("stack:height=10,ratio=" + text(ratio), 600); },
       .limits = stands},
      {.name = "mass of the ball at the end of a swinging chain of 100 links over a link's",
       .scene = "chain",
       .survives = holds_words,
       .rungs = {1, 10, 100, 1e3, 1e4, 1e5, 1e6},
       .run = [](double ratio) { return run_of("chain:links=100,ratio=" + text(ratio), 300); },
       .limits = holds},
      {.name = "links of a swinging chain",
       .scene = "chain",
       .survives = holds_words,
       .rungs = {10, 30, 100, 300, 1000, 3000},
       .run = [](double links) { return run_of("chain:ratio=1,links=" + text(links), 180); },
       .limits = holds},
      {.name = "length of the step, s, of a tower of ten boxes",
       .scene = "stack",
       .survives = stands_words,
       .rungs = {1.0 / 240, 1.0 / 120, 1.0 / 60, 1.0 / 30, 1.0 / 15, 1.0 / 8, 1.0 / 4},
       .run = [](double dt) { return run_of("stack:height=10", static_cast<int>(std::lround(10 / dt)), dt); },
       .limits = stands},
  };
}

Frontier climb(const Ladder& ladder, const std::vector<PeerDriver>& drivers, bool quick, const Stop& stop) {
  const std::vector<int> substep_counts = quick ? std::vector{4} : std::vector{1, 2, 4, 8, 16};
  Frontier frontier = {.ladder = ladder, .reaches = {}};
  for (const int substeps : substep_counts) frontier.reaches.push_back(climb_with_atoll(ladder, substeps, stop));
  for (const PeerDriver& driver : drivers) {
    for (const int substeps : substep_counts) frontier.reaches.push_back(climb_with_peer(ladder, driver, substeps));
  }
  return frontier;
}

}  // namespace atl::tradeoff
