#include "tune.h"

#include <iostream>

#include "failure.h"
#include "interrupt.h"
#include "names.h"
#include "standard_streams.h"

namespace atl::command {
namespace {

using tradeoff::Trial;
using tradeoff::Tuning;

std::string millimetres(double length) { return significant(1000 * length, 3) + " mm"; }

// "penetration 0.4 mm, joint gap 0.01 mm": what there is of the two.
std::string error_words(const Trial& trial) {
  const tradeoff::RestErrors& errors = trial.errors;
  const std::string penetration =
      "penetration " +
      (errors.penetration > 0 ? millimetres(errors.penetration) : "below " + millimetres(tradeoff::min_tuned_error));
  if (errors.joint_gap == 0) return penetration;
  const std::string gap = "joint gap " + millimetres(errors.joint_gap);
  return errors.penetration == 0 ? gap : penetration + ", " + gap;
}

// Substeps and solvers, whatever the scene's own are.
std::string settings_words(const Trial& trial) {
  const Settings& s = trial.configuration.settings;
  return plural(s.substeps, "substep") + ", contacts " + name_of(s.contact_solver) + ", joints " +
         name_of(s.joint_solver);
}

void tell_trial(const Trial& trial, double error) {
  std::cerr << "atoll: " << settings_words(trial) << ": ";
  if (trial.record.outcome != tradeoff::Outcome::Done) {
    std::cerr << trial.record.why << std::endl;
    return;
  }
  std::cerr << error_words(trial) << " at rest" << (trial.holds ? "" : ", too much") << "; "
            << significant(100 * trial.errors.steps_within, 3) << "% of all steps within " << millimetres(error)
            << std::endl;
}

void tell_choice(const Tuning& tuning) {
  for (const std::size_t timed : tuning.timed) {
    const Trial& trial = tuning.trials[timed];
    std::cerr << "atoll: " << (timed == *tuning.cheapest ? "cheapest: " : "also holds: ") << settings_words(trial)
              << ", " << significant(1000 * trial.record.cpu.median() * trial.record.dt, 3) << " ms of CPU time a step"
              << std::endl;
  }
}

// "settings": {...}, to be put into a scene file.
void write_block(std::ostream& out, const Trial& trial) {
  out << "\"settings\": " << settings_text(trial.configuration.settings) << "\n";
}

Failure nothing_holds(const tradeoff::ScenePlan& plan, double error, const Tuning& tuning) {
  const std::string best = tuning.smallest_error
                               ? "the best, " + settings_words(tuning.trials[*tuning.smallest_error]) + ", come to " +
                                     error_words(tuning.trials[*tuning.smallest_error]) + " at rest"
                               : "no run came to its end as it should; " + tuning.trials.front().record.why;
  return Failure(Status::CheckFailed, plan.scene.name + ": no fixed settings of up to " +
                                          std::to_string(tradeoff::tuning_ladder().back()) + " substeps hold " +
                                          millimetres(error) + ": " + best);
}

Tuning find(const tradeoff::ScenePlan& plan, const TuneOptions& options) {
  tradeoff::RunPolicy policy = tradeoff::RunPolicy::standard(false);
  policy.repeats = options.repeats.value_or(policy.repeats);
  policy.min_time = options.time.value_or(policy.min_time);
  policy.stop = interrupted;
  try {
    return tradeoff::tune(plan, options.error, policy, [&](const Trial& trial) { tell_trial(trial, options.error); });
  } catch (const tradeoff::Stopped&) {
    throw interruption(plan.scene.name, "before there were settings to print");
  } catch (const tradeoff::OtherBits& error) {
    throw Failure(Status::CheckFailed, error.what());
  }
}

}  // namespace

void tune(const TuneOptions& options) {
  if (options.error < tradeoff::min_tuned_error) {
    throw Failure(Status::Usage, "--error: found " + millimetres(options.error) + ", expected at least " +
                                     millimetres(tradeoff::min_tuned_error) + ", as smaller overlaps are not counted");
  }
  const tradeoff::ScenePlan plan = tradeoff::plan_to_tune(options.scene, options.seed, options.steps);
  const Tuning tuning = find(plan, options);
  if (tuning.cheapest) tell_choice(tuning);
  if (options.format == Format::Json) {
    write_tuning_json(std::cout, plan, options.error, tuning);
  } else if (tuning.cheapest) {
    write_block(std::cout, tuning.trials[*tuning.cheapest]);
  }
  finish_output();
  if (!tuning.cheapest) throw nothing_holds(plan, options.error, tuning);
}

}  // namespace atl::command
