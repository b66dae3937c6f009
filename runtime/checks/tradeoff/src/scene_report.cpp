#include "checks/tradeoff/scene_report.h"

#include <algorithm>

namespace atl::tradeoff {
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

// True if bodies were still falling onto each other at the end of Atoll's default run.
bool still_falls(const SceneReport& report) {
  const Record& own = report.records.front();
  return report.plan.chaotic() && own.outcome == Outcome::Done && own.touching < landed_share;
}

}  // namespace

void compare_all(SceneReport& report) {
  report.comparisons.clear();
  for (const std::string& measure : measures_of(report.records)) {
    report.comparisons.push_back(compare(report.records, measure));
    if (measure.starts_with("penetration") && still_falls(report)) {
      report.comparisons.back().verdict = {
          Verdict::Kind::NotJudged,
          "Overlaps are not judged: after " + std::to_string(report.plan.scene.steps) +
              " steps fewer than half of the bodies touch anything, so there are next to none. More steps are needed.",
          {}};
    }
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

}  // namespace atl::tradeoff
