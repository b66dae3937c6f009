#include "checks/tradeoff/table.h"

#include <algorithm>
#include <string_view>

#include "checks/tradeoff/axes.h"
#include "checks/tradeoff/number_text.h"

namespace atl::tradeoff {
namespace {

using Row = std::vector<std::string>;

std::vector<std::string> measures_of_all(std::span<const SceneReport> reports) {
  std::vector<std::string> names;
  for (const SceneReport& report : reports) {
    for (const Comparison& comparison : report.comparisons) {
      if (std::find(names.begin(), names.end(), comparison.measure) == names.end()) {
        names.push_back(comparison.measure);
      }
    }
  }
  return names;
}

// The step has a column of its own, which other engines have too.
bool is_column(const Axis& axis) { return std::string_view(axis.name) != "dt"; }

Table::Kind kind_of(const Axis& axis) {
  if (!axis.numeric) return Table::Kind::Text;
  return axis.accepts("0.5") ? Table::Kind::Number : Table::Kind::Integer;
}

std::string option(const Record& record, const char* name) {
  for (const auto& [key, value] : record.options) {
    if (key == name) return value;
  }
  return "";
}

void add_samples(Row& row, const Samples& samples) {
  if (samples.count() == 0) {
    row.insert(row.end(), 3, "");
  } else {
    for (const double value : {samples.median(), samples.min(), samples.max()}) row.push_back(exact(value));
  }
}

Row row_of(const SceneReport& report, const Record& record, const std::vector<std::string>& measures) {
  Row row = {report.plan.scene.name,        record.engine,           record.label,
             record.is_default ? "1" : "0", name_of(record.outcome), record.why,
             std::to_string(record.steps),  exact(record.dt)};
  for (const Axis& axis : axes()) {
    if (is_column(axis)) row.push_back(option(record, axis.name));
  }
  row.push_back(option(record, "options"));
  add_samples(row, record.cpu);
  add_samples(row, record.wall);
  for (const std::string& measure : measures) {
    const auto is_it = [&](const ErrorMeasure& error) { return error.name == measure; };
    const auto found = std::find_if(record.errors.begin(), record.errors.end(), is_it);
    row.push_back(found == record.errors.end() ? "" : exact(found->value));
  }
  return row;
}

}  // namespace

const char* name_of(Table::Kind kind) {
  constexpr const char* names[] = {"text", "flag", "integer", "number"};
  return names[static_cast<int>(kind)];
}

Table table_of(std::span<const SceneReport> reports) {
  using Kind = Table::Kind;
  Table table = {.columns = {{"scene", Kind::Text},
                             {"engine", Kind::Text},
                             {"label", Kind::Text},
                             {"default", Kind::Flag},
                             {"outcome", Kind::Text},
                             {"why", Kind::Text},
                             {"steps", Kind::Integer},
                             {"dt", Kind::Number}},
                 .rows = {}};
  for (const Axis& axis : axes()) {
    if (is_column(axis)) table.columns.push_back({axis.name, kind_of(axis)});
  }
  table.columns.push_back({"options", Kind::Text});
  for (const char* name : {"cpu_s_per_simulated_s", "cpu_min", "cpu_max", "ms_per_step", "ms_min", "ms_max"}) {
    table.columns.push_back({name, Kind::Number});
  }
  const std::vector<std::string> measures = measures_of_all(reports);
  for (const std::string& measure : measures) table.columns.push_back({measure, Kind::Number});
  for (const SceneReport& report : reports) {
    for (const Record& record : report.records) table.rows.push_back(row_of(report, record, measures));
  }
  return table;
}

}  // namespace atl::tradeoff
