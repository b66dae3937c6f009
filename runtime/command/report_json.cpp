#include <nlohmann/json.hpp>
#include <ostream>

#include "figures.h"
#include "interrupt.h"
#include "names.h"
#include "report.h"
#include "state/hex.h"

namespace atl::command {
namespace {

using Json = nlohmann::ordered_json;

Json target_json(const ErrorTarget& target) {
  Json object = Json::object();
  for (const TargetError error :
       {TargetError::Penetration, TargetError::JointGap, TargetError::Residual, TargetError::Motion}) {
    if (const double limit = limit_of(target, error); limit > 0) object[name_of(error)] = limit;
  }
  object["min_substeps"] = target.min_substeps;
  object["max_substeps"] = target.max_substeps;
  return object;
}

Json settings_json(const Settings& s) {
  return {{"substeps", s.substeps},
          {"target", s.target.is_set() ? target_json(s.target) : Json("off")},
          {"iterations", s.iterations},
          {"relax_iterations", s.relax_iterations},
          {"tolerance", s.tolerance},
          {"friction", name_of(s.friction)},
          {"warm_starting", s.warm_starting},
          {"stabilisation", name_of(s.stabilisation)},
          {"correction", s.correction},
          {"slop", s.slop},
          {"contact_hertz", s.contact_hertz ? Json(*s.contact_hertz) : Json("auto")},
          {"contact_damping_ratio", s.contact_damping_ratio},
          {"contact_push_speed", s.contact_push_speed},
          {"restitution_threshold", s.restitution_threshold ? Json(*s.restitution_threshold) : Json("auto")},
          {"contact_solver", name_of(s.contact_solver)},
          {"joint_solver", name_of(s.joint_solver)},
          {"joint_hertz", s.joint_hertz ? Json(*s.joint_hertz) : Json("auto")},
          {"joint_damping_ratio", s.joint_damping_ratio},
          {"sleeping", s.sleeping},
          {"sleep_speed", s.sleep_speed},
          {"time_to_sleep", s.time_to_sleep}};
}

Json phases_json(const RunResult& result) {
  Json phases = Json::object();
  for (int i = 0; i < phase_count; ++i) phases[phase_name(static_cast<Phase>(i))] = result.phase_ms[i];
  return phases;
}

Json solver_json(const RunResult& result) {
  Json phases = Json::object();
  for (std::size_t i = 0; i < solver_phase_count; ++i) {
    phases[solver_phase_name(static_cast<SolverPhase>(i))] = result.solver_ms[i];
  }
  return phases;
}

Json counts_json(const StepCounts& counts) {
  Json object = Json::object();
  for (const Count& count : named_counts(counts)) object[count.name] = count.value;
  return object;
}

Json errors_json(const RunResult& result) {
  Json object = Json::object();
  for (const ErrorMeasure& error : result.errors) object[error.name] = error.value;
  return object;
}

Json lost_json(const RunResult& result) {
  Json array = Json::array();
  for (const LostBody& lost : result.lost)
    array.push_back({{"body", lost.body}, {"step", lost.step}, {"why", lost.why}});
  return array;
}

Json solver_choices_json(const RunResult& result) {
  Json array = Json::array();
  for (const auto& [body, island] : result.solver_choices) {
    array.push_back({{"lowest_body", body},
                     {"bodies", island.bodies},
                     {"contacts", island.contacts},
                     {"why", island.why},
                     {"solved", island.direct          ? "direct"
                                : *island.why_not != 0 ? "swept"
                                                       : "refined"},
                     {"gave_up", island.gave_up},
                     {"why_not", island.why_not},
                     {"iterations", island.iterations}});
    if (island.ms > 0) array.back()["ms"] = island.ms;
  }
  return array;
}

// The error target over the whole run: its substeps, and the steps that missed it.
Json tally_json(const TargetTally& tally) {
  return {{"mean_substeps", tally.mean_substeps()},
          {"max_substeps", tally.max_substeps},
          {"missed_steps", tally.missed_steps},
          {"missed_targets", tally.missed_targets}};
}

Json missed_targets_json(const RunResult& result, const ErrorTarget& target) {
  Json array = Json::array();
  for (const auto& [body, island] : result.missed_targets) {
    array.push_back({{"lowest_body", body},
                     {"bodies", island.bodies},
                     {"contacts", island.contacts},
                     {"joints", island.joints},
                     {"error", name_of(island.error)},
                     {"measured", island.measured},
                     {"target", limit_of(target, island.error)},
                     {"unit", unit_of(island.error)},
                     {"substeps", island.substeps},
                     {"why", island.why}});
  }
  return array;
}

Json features_json(const std::array<FeatureReport, feature_count>& features) {
  Json array = Json::array();
  for (const FeatureReport& feature : features) {
    array.push_back({{"name", feature.name},
                     {"run", feature.run},
                     {"why", feature.why},
                     {"items", feature.items},
                     {"unit", feature.unit},
                     {"ms", feature.ms}});
  }
  return array;
}

}  // namespace

void write_json(std::ostream& out, const Scene& scene, const World& world, const RunResult& result) {
  const StepTimes& times = result.step_times;
  Json object = {
      {"scene", scene.name},
      {"bodies", body_counts(scene).dynamic},
      {"steps", result.steps},
      {"dt", scene.dt},
      {"threads", world.threads()},
      {"simd", name_of(world.simd())},
      {"settings", settings_json(scene.settings)},
      {"ms_per_step",
       {{"mean", times.mean},
        {"median", times.median},
        {"p99", times.p99},
        {"max", times.max},
        {"longest_step", times.longest}}},
      {"phases_ms", phases_json(result)},
  };
  if (scene.settings.profile) object["solver_ms"] = solver_json(result);
  object["counts"] = counts_json(result.last.counts);
  object["errors"] = errors_json(result);
  object["features"] = features_json(result.last.features);
  if (!result.solver_choices.empty()) object["solver_choices"] = solver_choices_json(result);
  if (scene.settings.target.is_set()) {
    object["target"] = tally_json(result.target);
    object["missed_targets"] = missed_targets_json(result, scene.settings.target);
  }
  if (!result.lost.empty()) object["quarantined"] = lost_json(result);
  if (result.interrupted) object["interrupted"] = {{"by", interrupt_name()}, {"steps_asked", scene.steps}};
  object["hash"] = hash_text(result.hash);
  // A name from a scene file is valid UTF-8 by then; one from a file's name need not be.
  out << object.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

}  // namespace atl::command
