#include "checks/tradeoff/tune.h"

#include <atoll/error_meter.h>
#include <atoll/errors.h>
#include <solver/select/error_target.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <span>

#include "atoll_runs.h"
#include "checks/tradeoff/setting_names.h"
#include "scene_traits.h"

namespace atl::tradeoff {
namespace {

constexpr int max_tuned_substeps = 64;
constexpr double rest_share = 0.25;  // of the steps, the last ones

// Errors after a step, as islands' targets count them.
class StepErrors {
 public:
  explicit StepErrors(const Scene& scene)
      : shapes_(placed_shapes(scene)),
        joints_(placed_joints(scene)),
        touches_(!nothing_touches(scene)),
        may_touch_(atl::may_touch(scene)) {}

  double penetration(std::span<const BodyState> states) {
    if (!touches_) return 0;
    for (std::size_t i = 0; i < states.size(); ++i) shapes_[i].pose = states[i].pose;
    return measure_penetration(shapes_, may_touch_).p99;
  }

  double joint_gap(std::span<const BodyState> states) {
    if (joints_.empty()) return 0;
    gaps_.clear();
    for (const PlacedJoint& joint : joints_) gaps_.push_back(measure_joint_drift({&joint, 1}, states).max);
    const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(gaps_.size())));
    const auto at = gaps_.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(gaps_.begin(), at, gaps_.end());
    return *at;
  }

 private:
  std::vector<PlacedShape> shapes_;
  std::vector<PlacedJoint> joints_;
  bool touches_;
  MayTouch may_touch_;
  std::vector<double> gaps_;
};

void run_trial(const ScenePlan& plan, double error, const Stop& stop, Trial& trial) {
  const Scene& scene = plan.scene;
  Record& record = trial.record;
  World world = make_world(plan, trial.configuration, false);
  const std::vector<BodyId> ids = build_scene(scene, world);
  StepErrors after_step(scene);
  std::vector<BodyState> states;
  const auto rest_begins = static_cast<int>((1 - rest_share) * record.steps);
  int within = 0;
  for (int step = 1; step <= record.steps; ++step) {
    stop_if_asked(stop);
    apply_forces(scene, world, ids);
    const StepReport report = world.step(trial.configuration.dt);
    trial.selects |= report.counts.direct_islands + report.counts.refined_islands + report.counts.unsolved_islands > 0;
    if (report.first_quarantined >= 0) {
      record.outcome = Outcome::NonFinite;
      record.why = "became non-finite in step " + std::to_string(step) + " of " + std::to_string(record.steps);
      return;
    }
    states = body_states(world, ids);
    const double penetration = after_step.penetration(states), gap = after_step.joint_gap(states);
    within += penetration <= error && gap <= error;
    if (step <= rest_begins) continue;
    trial.errors.penetration = std::max(trial.errors.penetration, penetration);
    trial.errors.joint_gap = std::max(trial.errors.joint_gap, gap);
  }
  trial.errors.steps_within = static_cast<double>(within) / record.steps;
  record.hash = world.state_hash();
  // A collapsed structure may overlap less than one that stands, so a run that fell doesn't count.
  ErrorMeter meter(scene, ErrorMeter::Follow::End);
  meter.observe(record.steps * record.dt, states);
  if (meter.fell()) {
    record.outcome = Outcome::Fell;
    record.why = "fell: a body left its place for good";
  }
  trial.holds = record.outcome == Outcome::Done && trial.errors.worst() <= error;
}

class Search {
 public:
  Search(const ScenePlan& plan, double error, const Stop& stop, const std::function<void(const Trial&)>& tried,
         std::vector<Trial>& trials)
      : plan_(plan), error_(error), stop_(stop), tried_(tried), trials_(trials), ladder_(tuning_ladder()) {}

  /// The trial of the fewest substeps that hold with these solvers.
  std::optional<std::size_t> fewest_substeps(const Configuration& solvers) {
    solvers_ = solvers;
    by_rung_.assign(ladder_.size(), std::nullopt);
    std::size_t rung = bisect();
    while (rung < ladder_.size() && !is_confirmed(rung)) ++rung;
    if (rung == ladder_.size()) return std::nullopt;
    return by_rung_[rung];
  }

 private:
  // The rung that holds while the one below does not, or the ladder's end.
  std::size_t bisect() {
    constexpr int guesses = 2;
    std::size_t begin = 0, end = ladder_.size();  // those below begin fail, the one at end holds
    std::size_t probe = rung_at_least(4);
    for (int probes = 0; begin < end; ++probes) {
      const bool held = holds(probe);
      (held ? end : begin) = held ? probe : probe + 1;
      if (begin == end) break;
      const std::optional<std::size_t> guess = probes < guesses ? guess_from(probe) : std::nullopt;
      probe = guess ? std::clamp(*guess, begin, end - 1) : begin + (end - begin) / 2;
    }
    return end;
  }

  // By the law that errors fall with the square of the substeps.
  std::optional<std::size_t> guess_from(std::size_t rung) const {
    const Trial& trial = trials_[*by_rung_[rung]];
    if (trial.record.outcome != Outcome::Done) return std::nullopt;
    return rung_at_least(ladder_[rung] * std::sqrt(trial.errors.worst() / error_));
  }

  std::size_t rung_at_least(double substeps) const {
    return static_cast<std::size_t>(
        std::find_if(ladder_.begin(), ladder_.end(), [=](int rung) { return rung >= substeps; }) - ladder_.begin());
  }

  bool is_confirmed(std::size_t rung) { return holds(rung) && (rung + 1 == ladder_.size() || holds(rung + 1)); }

  bool holds(std::size_t rung) {
    std::optional<std::size_t>& place = by_rung_[rung];
    if (!place) {
      Trial trial = {.configuration = solvers_, .record = {}, .errors = {}};
      trial.configuration.settings.substeps = ladder_[rung];
      trial.record = describe(plan_, trial.configuration);
      run_trial(plan_, error_, stop_, trial);
      if (tried_) tried_(trial);
      place = trials_.size();
      trials_.push_back(std::move(trial));
    }
    return trials_[*place].holds;
  }

  const ScenePlan& plan_;
  double error_;
  const Stop& stop_;
  const std::function<void(const Trial&)>& tried_;
  std::vector<Trial>& trials_;
  std::vector<int> ladder_;
  Configuration solvers_;
  std::vector<std::optional<std::size_t>> by_rung_;  // trials of these solvers
};

std::vector<JointSolver> joint_solvers_of(const ScenePlan& plan) {
  std::vector<JointSolver> solvers;
  for (const std::string& name : different_joint_solvers(plan.scene)) solvers.push_back(joint_solver_named(name));
  if (solvers.empty()) solvers.push_back(plan.scene.settings.joint_solver);
  return solvers;
}

// Solvers to try; the one that leaves all contacts to sweeps comes last.
std::vector<ContactSolver> contact_solvers_of(const ScenePlan& plan) {
  const ContactSolver own = plan.scene.settings.contact_solver;
  if (nothing_touches(plan.scene)) return {own};
  std::vector<ContactSolver> solvers = {ContactSolver::Auto, ContactSolver::Iterative};
  if (own == ContactSolver::Direct) solvers.insert(solvers.begin(), own);
  return solvers;
}

void time_trials(const ScenePlan& plan, const RunPolicy& policy, Tuning& tuning) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> spent(tuning.timed.size(), 0);  // s
  for (int round = 0; round < policy.repeats; ++round) {
    for (std::size_t i = 0; i < tuning.timed.size(); ++i) {
      if (spent[i] >= RunPolicy::enough) continue;
      Trial& trial = tuning.trials[tuning.timed[i]];
      const Clock::time_point start = Clock::now();
      measure_time(plan, trial.configuration, policy.min_time, trial.record, policy.stop);
      spent[i] += std::chrono::duration<double>(Clock::now() - start).count();
    }
  }
}

}  // namespace

std::vector<int> tuning_ladder() {
  std::vector<int> ladder;
  for (const std::uint16_t rung : solver::substep_rungs) {
    if (rung <= max_tuned_substeps) ladder.push_back(rung);
  }
  return ladder;
}

ScenePlan plan_to_tune(const std::string& address, std::uint64_t seed, std::optional<int> steps) {
  ScenePlan plan = {.address = address, .scene = load_scene(address, seed)};
  Scene& scene = plan.scene;
  plan.scene_steps = scene.steps;
  scene.steps = steps.value_or(scene.steps);
  scene.settings.target = {};
  plan.large = dynamic_bodies(scene) > max_bodies_of_small;
  plan.configurations = {{.settings = scene.settings, .dt = scene.dt, .threads = 1}};
  return plan;
}

Tuning tune(const ScenePlan& plan, double error, const RunPolicy& policy,
            const std::function<void(const Trial&)>& tried) {
  Tuning tuning;
  Search search(plan, error, policy.stop, tried, tuning.trials);
  for (const JointSolver joints : joint_solvers_of(plan)) {
    bool selects = true;  // of contacts, with the solver before
    for (const ContactSolver contacts : contact_solvers_of(plan)) {
      // If Auto selected nothing but sweeps, Iterative gives the same run: skip it.
      if (contacts == ContactSolver::Iterative && !selects) continue;
      Configuration solvers = plan.configurations.front();
      solvers.settings.joint_solver = joints;
      solvers.settings.contact_solver = contacts;
      const std::size_t before = tuning.trials.size();
      if (const auto found = search.fewest_substeps(solvers)) tuning.timed.push_back(*found);
      selects = std::any_of(tuning.trials.begin() + static_cast<std::ptrdiff_t>(before), tuning.trials.end(),
                            [](const Trial& trial) { return trial.selects; });
    }
  }
  time_trials(plan, policy, tuning);
  for (const std::size_t trial : tuning.timed) {
    const auto cost = [&](std::size_t of) { return tuning.trials[of].record.cpu.median(); };
    if (!tuning.cheapest || cost(trial) < cost(*tuning.cheapest)) tuning.cheapest = trial;
  }
  for (std::size_t i = 0; i < tuning.trials.size(); ++i) {
    if (tuning.trials[i].record.outcome != Outcome::Done) continue;
    const double before = tuning.smallest_error ? tuning.trials[*tuning.smallest_error].errors.worst()
                                                : std::numeric_limits<double>::infinity();
    if (tuning.trials[i].errors.worst() < before) tuning.smallest_error = i;
  }
  return tuning;
}

}  // namespace atl::tradeoff
