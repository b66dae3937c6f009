#include "checks/tradeoff/scene_sweep.h"

#include <chrono>

#include "atoll_runs.h"
#include "checks/tradeoff/number_text.h"

namespace atl::tradeoff {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::int64_t dynamic_bodies_of(const ScenePlan& plan) { return static_cast<std::int64_t>(dynamic_bodies(plan.scene)); }

std::int64_t work_of(const ScenePlan& plan, const Configuration& configuration) {
  const Settings& s = configuration.settings;
  return dynamic_bodies_of(plan) * plan.steps(configuration) * s.substeps * (1 + s.iterations + s.relax_iterations);
}

// Other engines are taken to be about as slow as this many sweeps a step.
std::int64_t work_of_peer(const ScenePlan& plan) { return dynamic_bodies_of(plan) * plan.scene.steps * 60; }

bool is_run(const PeerSetting& setting, const ScenePlan& plan) { return setting.large || !plan.large; }

// Times one setting once.
struct TimingJob {
  std::function<void()> run;
  std::int64_t work = 0;
  double spent = 0;  ///< s of wall time
};

class SceneSweep {
 public:
  SceneSweep(SceneReport& report, std::uint64_t seed, const RunPolicy& policy, const WorkDone& work_done)
      : report_(report), seed_(seed), policy_(policy), work_done_(work_done) {}

  void measure_atoll() {
    const ScenePlan& plan = report_.plan;
    // Jobs keep places, since the list of records grows.
    for (const Configuration& configuration : plan.configurations) {
      Record record = describe(plan, configuration);
      if (record.same_bits) {
        const Record& own = report_.records.front();
        record.outcome = own.outcome;
        record.why = own.why;
        record.errors = own.errors;
        record.hash = own.hash;
      } else {
        tradeoff::measure_errors(plan, configuration, record, policy_.stop);
        work_done_(work_of(plan, configuration));
      }
      report_.records.push_back(std::move(record));
      if (!report_.records.back().hash) continue;
      const auto time = [this, &plan, &configuration, place = report_.records.size() - 1] {
        tradeoff::measure_time(plan, configuration, policy_.min_time, report_.records[place], policy_.stop);
      };
      jobs_.push_back({.run = time, .work = work_of(plan, configuration)});
    }
  }

  void measure_peer(const PeerDriver& driver) {
    const ScenePlan& plan = report_.plan;
    const PeerRun run = {.scene = plan.address, .steps = plan.scene.steps, .dt = plan.scene.dt, .seed = seed_};
    const Clock::time_point start = Clock::now();
    for (const PeerSetting& setting : driver.settings()) {
      if (!is_run(setting, plan)) continue;
      Record record = driver.describe(setting, run);
      if (seconds_since(start) < policy_.peer_budget) {
        driver.measure_errors(setting, run, record);
      } else {
        record.outcome = Outcome::Skipped;
        record.why = "not tried, as the settings before took over " + fixed(policy_.peer_budget, 1) + " s";
      }
      work_done_(work_of_peer(plan));
      report_.records.push_back(std::move(record));
      const Record& measured = report_.records.back();
      const bool hopeless = measured.outcome == Outcome::Refused || measured.outcome == Outcome::TooSlow;
      if (measured.is_default && hopeless) return;
      if (!measured.came_to_its_end()) continue;
      const auto time = [this, &driver, &setting, run, place = report_.records.size() - 1] {
        driver.measure_time(setting, run, policy_.min_time, report_.records[place]);
      };
      jobs_.push_back({.run = time, .work = work_of_peer(plan)});
    }
  }

  void measure_times() {
    for (int round = 0; round < policy_.repeats; ++round) {
      for (TimingJob& job : jobs_) {
        if (job.spent < RunPolicy::enough) {
          const Clock::time_point start = Clock::now();
          job.run();
          job.spent += seconds_since(start);
        }
        work_done_(job.work);
      }
    }
  }

 private:
  SceneReport& report_;
  std::uint64_t seed_;
  RunPolicy policy_;
  const WorkDone& work_done_;
  std::vector<TimingJob> jobs_;
};

// Runs that came to their end but were not timed can't be compared; nor can others without the scene's own settings.
void leave_out_untimed(std::vector<Record>& records) {
  const auto untimed = [](const Record& record) { return record.came_to_its_end() && record.cpu.count() == 0; };
  if (!records.empty() && untimed(records.front())) records.clear();
  std::erase_if(records, untimed);
}

}  // namespace

RunPolicy RunPolicy::standard(bool quick) {
  return {.repeats = quick ? 1 : 3, .min_time = quick ? 0.02 : 0.03, .peer_budget = quick ? 0.5 : 15.0};
}

std::int64_t estimate_work(const ScenePlan& plan, const std::vector<PeerDriver>& drivers, const RunPolicy& policy) {
  std::int64_t work = 0;
  for (const Configuration& configuration : plan.configurations) work += work_of(plan, configuration);
  for (const PeerDriver& driver : drivers) {
    for (const PeerSetting& setting : driver.settings()) work += is_run(setting, plan) ? work_of_peer(plan) : 0;
  }
  return work * (1 + policy.repeats);
}

SceneReport sweep_scene(ScenePlan plan, const std::vector<PeerDriver>& drivers, const RunPolicy& policy,
                        std::uint64_t seed, const WorkDone& work_done) {
  SceneReport report = {.plan = std::move(plan), .records = {}, .comparisons = {}};
  SceneSweep sweep(report, seed, policy, work_done);
  try {
    sweep.measure_atoll();
    for (const PeerDriver& driver : drivers) sweep.measure_peer(driver);
    sweep.measure_times();
  } catch (const Stopped&) {
    leave_out_untimed(report.records);
  }
  compare_all(report);
  return report;
}

}  // namespace atl::tradeoff
