#include <algorithm>
#include <iostream>
#include <string>

#include "../failure.h"
#include "../interrupt.h"
#include "../progress.h"
#include "../standard_streams.h"
#include "checks.h"
#include "chosen_cases.h"
#include "stability_report.h"

namespace atl::command {
namespace {

using stability::CaseResult;
using stability::StabilityCase;

std::vector<CaseResult> run_cases(const std::vector<StabilityCase>& cases) {
  Progress progress(static_cast<std::int64_t>(cases.size()), "cases");
  std::vector<CaseResult> results;
  for (const StabilityCase& test : cases) {
    results.push_back(stability::run_case(test));
    progress.update(static_cast<std::int64_t>(results.size()));
    if (interrupted()) break;
  }
  return results;
}

}  // namespace

void check_stability(const VerifyOptions& options) {
  std::vector<StabilityCase> cases = chosen_cases(stability::stability_cases(), options.cases, "--stability");
  const std::vector<CaseResult> results = run_cases(cases);
  const std::size_t asked = cases.size();
  cases.resize(results.size());
  if (options.format == Format::Json) {
    write_stability_json(std::cout, cases, results);
  } else {
    write_stability_text(std::cout, cases, results);
  }
  finish_output();
  const auto failed = std::count_if(results.begin(), results.end(), [](const CaseResult& r) { return r.failed(); });
  if (failed > 0) {
    throw Failure(Status::CheckFailed,
                  std::to_string(failed) + " of " + std::to_string(cases.size()) + " stability cases fail");
  }
  if (cases.size() < asked) throw interrupted_suite("--stability", cases.size(), asked);
}

}  // namespace atl::command
