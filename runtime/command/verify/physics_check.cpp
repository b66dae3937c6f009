#include <iostream>
#include <string>

#include "../failure.h"
#include "../interrupt.h"
#include "../progress.h"
#include "../standard_streams.h"
#include "checks.h"
#include "chosen_cases.h"
#include "physics_report.h"

namespace atl::command {

using physics::CaseRuns;
using physics::PhysicsCase;

void check_physics(const VerifyOptions& options) {
  std::vector<PhysicsCase> cases = chosen_cases(physics::physics_cases(), options.cases, "--physics");
  Progress progress(static_cast<std::int64_t>(cases.size()), "cases");
  std::vector<CaseRuns> results;
  for (const PhysicsCase& test : cases) {
    CaseRuns of_case;
    for (const int divisor : refinements) {
      of_case.own.push_back(run_case(test, test.dt / divisor));
      if (!options.refine || test.statistical) break;
    }
    constexpr double default_dt = physics::Resolution{}.dt;
    of_case.by_default = test.dt == default_dt ? of_case.own.front() : run_case(test, default_dt);
    results.push_back(std::move(of_case));
    progress.update(static_cast<std::int64_t>(results.size()));
    if (interrupted()) break;
  }
  const std::size_t asked = cases.size();
  cases.resize(results.size());
  if (options.format == Format::Json) {
    write_physics_json(std::cout, cases, results);
  } else {
    write_physics_text(std::cout, cases, results);
  }
  finish_output();
  std::size_t failed = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) failed += expected(cases[i], results[i].own) ? 0 : 1;
  if (failed > 0) {
    throw Failure(Status::CheckFailed, std::to_string(failed) + " of " + std::to_string(cases.size()) +
                                           " physics cases are not as expected");
  }
  if (cases.size() < asked) throw interrupted_suite("--physics", cases.size(), asked);
}

}  // namespace atl::command
