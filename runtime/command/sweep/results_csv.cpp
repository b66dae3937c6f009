#include <algorithm>
#include <ostream>

#include "axes.h"
#include "results.h"

namespace atl::command {
namespace {

// RFC 4180.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::vector<std::string> measures_of(const SweepResults& results) {
  std::vector<std::string> names;
  for (const SceneReport& report : results.scenes) {
    for (const Comparison& comparison : report.comparisons) {
      if (std::find(names.begin(), names.end(), comparison.measure) == names.end()) {
        names.push_back(comparison.measure);
      }
    }
  }
  return names;
}

std::string option(const Record& record, const char* name) {
  for (const auto& [key, value] : record.options) {
    if (key == name) return value;
  }
  return "";
}

void write_samples(std::ostream& out, const Samples& samples) {
  out << ',';
  if (samples.count() == 0) {
    out << ",,";
  } else {
    out << samples.median() << ',' << samples.min() << ',' << samples.max();
  }
}

void write_row(std::ostream& out, const SceneReport& report, const Record& record,
               const std::vector<std::string>& measures) {
  out << cell(report.plan.scene.name) << ',' << cell(record.engine) << ',' << cell(record.label) << ','
      << (record.is_default ? 1 : 0) << ',' << name_of(record.outcome) << ',' << cell(record.why) << ',' << record.steps
      << ',' << record.dt;
  for (const Axis& axis : axes()) {
    if (std::string_view(axis.name) != "dt") out << ',' << option(record, axis.name);
  }
  out << ',' << cell(option(record, "options"));
  write_samples(out, record.cpu);
  write_samples(out, record.wall);
  for (const std::string& measure : measures) {
    out << ',';
    for (const ErrorMeasure& error : record.errors) {
      if (error.name == measure) out << error.value;
    }
  }
  out << '\n';
}

}  // namespace

void write_results_csv(std::ostream& out, const SweepResults& results) {
  const std::vector<std::string> measures = measures_of(results);
  out.precision(17);
  out << "scene,engine,label,default,outcome,why,steps,dt";
  for (const Axis& axis : axes()) {
    if (std::string_view(axis.name) != "dt") out << ',' << axis.name;
  }
  out << ",options,cpu_s_per_simulated_s,cpu_min,cpu_max,ms_per_step,ms_min,ms_max";
  for (const std::string& measure : measures) out << ',' << measure;
  out << '\n';
  for (const SceneReport& report : results.scenes) {
    for (const Record& record : report.records) write_row(out, report, record, measures);
  }
}

}  // namespace atl::command
