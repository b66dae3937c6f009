#include "scene_report.h"

#include <algorithm>

namespace atl::command {
namespace {

std::vector<std::string> measures_of(const std::vector<Record>& records) {
  std::vector<std::string> names;
  for (const Record& record : records) {
    for (const ErrorMeasure& error : record.errors) {
      if (std::find(names.begin(), names.end(), error.name) == names.end()) names.push_back(error.name);
    }
  }
  for (const char* first : {"penetration_mean", "joint_gap_run_mean", "analytic_error"}) {
    const auto found = std::find(names.begin(), names.end(), first);
    if (found != names.end()) std::rotate(names.begin(), found, found + 1);
  }
  return names;
}

}  // namespace

void compare_all(SceneReport& report) {
  report.comparisons.clear();
  for (const std::string& measure : measures_of(report.records)) {
    report.comparisons.push_back(compare(report.records, measure));
  }
}

std::string unit_of(const std::string& measure, const std::vector<Record>& records) {
  for (const Record& record : records) {
    for (const ErrorMeasure& error : record.errors) {
      if (error.name == measure && !error.unit.empty()) return error.unit;
    }
  }
  return "";
}

}  // namespace atl::command
