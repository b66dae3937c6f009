#include "stability_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "../names.h"

namespace atl::command {
namespace {

using Json = nlohmann::ordered_json;
using stability::CaseResult;
using stability::Finding;
using stability::StabilityCase;

const char* status_of(const Finding& finding) {
  if (!finding.known_failure.empty()) return finding.holds() ? "ok, no longer a known failure" : "known failure";
  return finding.holds() ? "ok" : "FAILS";
}

/// Widths of the table's columns.
struct CaseColumns {
  int name = 4;
  int criterion = 9;
};

CaseColumns case_columns(std::span<const StabilityCase> cases) {
  CaseColumns columns;
  for (const StabilityCase& test : cases) {
    columns.name = std::max(columns.name, static_cast<int>(test.name.size()));
    for (const auto& criterion : test.criteria) {
      const std::size_t unit = criterion.unit.empty() ? 0 : criterion.unit.size() + 2;
      columns.criterion = std::max(columns.criterion, static_cast<int>(criterion.name.size() + unit));
    }
  }
  return columns;
}

constexpr int value_width = 11;

void write_row(std::ostream& out, const CaseColumns& columns, const std::string& name, const std::string& criterion,
               const std::array<std::string, 5>& numbers, const std::string& status) {
  out << std::left << std::setw(columns.name + 2) << name << std::setw(columns.criterion) << criterion << std::right;
  for (const std::string& number : numbers) out << std::setw(value_width) << number;
  out << "  " << status << "\n";
}

void write_case(std::ostream& out, const CaseColumns& columns, const StabilityCase& test, const CaseResult& result) {
  bool first = true;
  for (const Finding& finding : result.findings) {
    const std::string unit = finding.unit.empty() ? "" : ", " + finding.unit;
    write_row(out, columns, first ? test.name : "", finding.criterion + unit,
              {significant(finding.value, 3), significant(finding.limit, 3), significant(finding.margin(), 3),
               first ? significant(result.ms_per_step, 3) : "", first ? significant(result.worst_step, 3) : ""},
              status_of(finding));
    first = false;
  }
}

void write_bad_state(std::ostream& out, const StabilityCase& test, const CaseResult& result) {
  if (!result.bad_state) return;
  out << test.name << ": body " << result.bad_state->body << " is non-finite, or without orientation, after step "
      << result.bad_state->step << " of " << test.steps << "\n";
}

// A paragraph a reason, with what fails for it, in the order in which they come up.
void write_known_failures(std::ostream& out, std::span<const StabilityCase> cases,
                          std::span<const CaseResult> results) {
  std::vector<std::pair<std::string, std::string>> reasons;
  for (std::size_t i = 0; i < results.size(); ++i) {
    for (const Finding& finding : results[i].findings) {
      if (finding.known_failure.empty() || finding.holds()) continue;
      auto at = std::find_if(reasons.begin(), reasons.end(),
                             [&](const auto& reason) { return reason.first == finding.known_failure; });
      if (at == reasons.end()) at = reasons.insert(reasons.end(), {finding.known_failure, ""});
      at->second += (at->second.empty() ? "" : "; ") + cases[i].name + ", " + finding.criterion;
    }
  }
  for (const auto& [reason, failures] : reasons) {
    out << "known failures, because " << reason << ":\n  " << failures << "\n";
  }
}

struct Counts {
  std::size_t ok = 0;
  std::size_t fail = 0;
  std::size_t known = 0;
};

Counts count(std::span<const CaseResult> results) {
  Counts counts;
  for (const CaseResult& result : results) {
    for (const Finding& finding : result.findings) {
      (finding.holds() ? counts.ok : finding.known_failure.empty() ? counts.fail : counts.known)++;
    }
  }
  return counts;
}

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json case_json(const StabilityCase& test, const CaseResult& result) {
  Json criteria = Json::array();
  for (const Finding& finding : result.findings) {
    Json criterion = {{"name", finding.criterion},          {"unit", finding.unit},
                      {"value", finite(finding.value)},     {"limit", finding.limit},
                      {"margin", finite(finding.margin())}, {"status", status_of(finding)}};
    if (!finding.known_failure.empty()) criterion["known_failure"] = finding.known_failure;
    criteria.push_back(std::move(criterion));
  }
  Json object = {{"name", test.name},
                 {"what", test.what},
                 {"steps", test.steps},
                 {"ms_per_step", result.ms_per_step},
                 {"worst_step_over_median", result.worst_step},
                 {"failed", result.failed()}};
  if (result.bad_state) {
    object["bad_state"] = {{"step", result.bad_state->step}, {"body", result.bad_state->body}};
  }
  object["criteria"] = std::move(criteria);
  return object;
}

}  // namespace

void write_stability_text(std::ostream& out, std::span<const StabilityCase> cases,
                          std::span<const CaseResult> results) {
  const CaseColumns columns = case_columns(cases);
  write_row(out, columns, "case", "criterion", {"value", "limit", "margin", "ms a step", "worst / ms"}, "");
  for (std::size_t i = 0; i < results.size(); ++i) write_case(out, columns, cases[i], results[i]);
  out << "\n";
  for (std::size_t i = 0; i < results.size(); ++i) write_bad_state(out, cases[i], results[i]);
  write_known_failures(out, cases, results);
  const Counts counts = count(results);
  out << cases.size() << (cases.size() == 1 ? " case: " : " cases: ") << counts.ok << " criteria hold, " << counts.fail
      << " fail, " << counts.known << " are known to fail\n";
}

void write_stability_json(std::ostream& out, std::span<const StabilityCase> cases,
                          std::span<const CaseResult> results) {
  Json array = Json::array();
  for (std::size_t i = 0; i < results.size(); ++i) array.push_back(case_json(cases[i], results[i]));
  const Counts counts = count(results);
  const Json object = {{"format", "atoll-stability"},
                       {"version", 1},
                       {"ok", counts.ok},
                       {"fail", counts.fail},
                       {"known_failures", counts.known},
                       {"cases", std::move(array)}};
  out << object.dump(2) << '\n';
}

}  // namespace atl::command
