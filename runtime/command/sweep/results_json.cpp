#include <atoll/scene.h>

#include <nlohmann/json.hpp>
#include <ostream>

#include "../figures.h"
#include "../measure_words.h"
#include "checks/tradeoff/axes.h"
#include "results.h"
#include "results_object.h"
#include "state/hex.h"

namespace atl::command {
namespace {

using namespace tradeoff;

using Json = nlohmann::ordered_json;

Json samples_json(const Samples& samples) {
  if (samples.count() == 0) return nullptr;
  return {{"median", samples.median()}, {"min", samples.min()}, {"max", samples.max()}, {"runs", samples.count()}};
}

Json options_json(const Record& record) {
  Json options = Json::object();
  for (const auto& [name, value] : record.options) {
    const bool numeric = name != "options" && find_axis(name).numeric;
    options[name] = numeric ? Json::parse(value) : Json(value);
  }
  return options;
}

Json record_json(const Record& record) {
  Json errors = Json::object();
  for (const ErrorMeasure& error : record.errors) errors[error.name] = error.value;
  return {{"engine", record.engine},
          {"label", record.label},
          {"default", record.is_default},
          {"same_bits", record.same_bits},
          {"options", options_json(record)},
          {"threads", record.threads},
          {"steps", record.steps},
          {"dt", record.dt},
          {"outcome", name_of(record.outcome)},
          {"why", record.why},
          {"errors", errors},
          {"cpu_s_per_simulated_s", samples_json(record.cpu)},
          {"ms_per_step", samples_json(record.wall)},
          {"hash", record.hash ? Json(hash_text(*record.hash)) : Json()}};
}

Json comparison_json(const Comparison& comparison, const SceneReport& report) {
  Json matches = Json::array();
  for (const auto& match : comparison.matches) {
    matches.push_back(match ? Json{{"run", match->record}, {"time_ratio", match->time_ratio}} : Json());
  }
  const Verdict& verdict = comparison.verdict;
  return {{"measure", comparison.measure},
          {"unit", unit_of(comparison.measure, report.records)},
          {"help", describe_measure(comparison.measure, report.plan.scene)},
          {"verdict",
           {{"kind", name_of(verdict.kind)},
            {"text", verdict.text},
            {"rival", verdict.rival ? Json(*verdict.rival) : Json()}}},
          {"atoll_front", comparison.atoll_front},
          {"peer_front", comparison.peer_front},
          {"fastest_other_at_no_more_error", matches}};
}

std::string help_of(const std::string& address) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    if (scene.name == address.substr(0, address.find(':'))) return scene.help;
  }
  return "";
}

Json scene_json(const SceneReport& report) {
  const ScenePlan& plan = report.plan;
  const Scene& scene = plan.scene;
  Json records = Json::array(), comparisons = Json::array();
  for (const Record& record : report.records) records.push_back(record_json(record));
  for (const Comparison& comparison : report.comparisons) comparisons.push_back(comparison_json(comparison, report));
  return {{"name", scene.name},
          {"help", help_of(plan.address)},
          {"metric", scene.closed_form ? scene.closed_form->metric : ""},
          {"source", scene.closed_form ? scene.closed_form->source : ""},
          {"bodies", body_counts(scene).dynamic},
          {"steps", scene.steps},
          {"scene_steps", plan.scene_steps},
          {"dt", scene.dt},
          {"simulated_s", plan.simulated_time()},
          {"large", plan.large},
          {"at_rest", scene.starts_at_rest},
          {"chaotic", plan.chaotic()},
          {"view", report.view},
          {"runs", records},
          {"comparisons", comparisons}};
}

Json frontier_json(const Frontier& frontier) {
  Json reaches = Json::array();
  for (const Reach& reach : frontier.reaches) {
    reaches.push_back({{"engine", reach.engine},
                       {"substeps", reach.substeps},
                       {"default", reach.is_default},
                       {"reached", reach.rung ? Json(*reach.rung) : Json()},
                       {"ms_per_step", reach.rung ? Json(reach.ms_per_step) : Json()}});
  }
  return {{"name", frontier.ladder.name},
          {"scene", frontier.ladder.scene},
          {"survives", frontier.ladder.survives},
          {"rungs", frontier.ladder.rungs},
          {"reaches", reaches}};
}

}  // namespace

Json results_object(const SweepResults& results) {
  Json engines = Json::array(), scenes = Json::array();
  for (const EngineVersion& engine : results.engines) {
    engines.push_back({{"name", engine.name}, {"version", engine.version}, {"precision", engine.precision}});
  }
  for (const SceneReport& report : results.scenes) scenes.push_back(scene_json(report));
  Json frontiers = Json::array();
  for (const Frontier& frontier : results.frontiers) frontiers.push_back(frontier_json(frontier));
  const Surroundings& around = results.surroundings;
  Json object = {
      {"format", "atoll-sweep"},
      {"version", 1},
      {"machine",
       {{"cpu", around.cpu}, {"cores", around.cores}, {"compiler", around.compiler}, {"system", around.system}}},
      {"engines", engines},
      {"quick", results.quick},
      {"repeats", results.repeats},
      {"min_time_s", results.time},
      {"seed", results.seed},
      {"no_error", no_error},
      {"scenes", scenes},
      {"frontiers", frontiers}};
  if (results.interrupted) object["interrupted"] = true;
  return object;
}

void write_results_json(std::ostream& out, const SweepResults& results) {
  out << results_object(results).dump(1, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace atl::command
