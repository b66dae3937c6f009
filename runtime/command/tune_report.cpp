#include <nlohmann/json.hpp>
#include <ostream>

#include "names.h"
#include "tune.h"

namespace atl::command {
namespace {

using Json = nlohmann::ordered_json;

Json trial_json(const tradeoff::Trial& trial) {
  const Settings& settings = trial.configuration.settings;
  Json object = {{"substeps", settings.substeps},
                 {"contact_solver", name_of(settings.contact_solver)},
                 {"joint_solver", name_of(settings.joint_solver)},
                 {"outcome", tradeoff::name_of(trial.record.outcome)},
                 {"holds", trial.holds}};
  if (trial.record.outcome == tradeoff::Outcome::Done) {
    object["penetration"] = trial.errors.penetration;
    object["joint_gap"] = trial.errors.joint_gap;
    object["steps_within"] = trial.errors.steps_within;
  }
  if (trial.record.cpu.count() > 0) object["cpu_s_per_simulated_s"] = trial.record.cpu.median();
  return object;
}

}  // namespace

void write_tuning_json(std::ostream& out, const tradeoff::ScenePlan& plan, double error,
                       const tradeoff::Tuning& tuning) {
  Json trials = Json::array();
  for (const tradeoff::Trial& trial : tuning.trials) trials.push_back(trial_json(trial));
  Json settings;  // null where none hold
  if (tuning.cheapest) settings = Json::parse(settings_text(tuning.trials[*tuning.cheapest].configuration.settings));
  const Json object = {{"scene", plan.scene.name},
                       {"error", error},
                       {"steps", plan.scene.steps},
                       {"dt", plan.scene.dt},
                       {"settings", settings},
                       {"cheapest", tuning.cheapest ? Json(*tuning.cheapest) : Json()},
                       {"smallest_error", tuning.smallest_error ? Json(*tuning.smallest_error) : Json()},
                       {"trials", trials}};
  out << object.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

}  // namespace atl::command
