#include "physics_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <ostream>
#include <string>

#include "../names.h"

namespace atl::command {
namespace {

using physics::CaseRuns;
using physics::PhysicsCase;
using physics::PhysicsResult;

const char* physics_status(const PhysicsCase& test, std::span<const PhysicsResult> runs) {
  const PhysicsResult& result = runs.front();
  if (result.expected(test) && !expected(test, runs)) {
    return test.known_growth.empty() ? "GROWS in finer steps" : "ok, no longer known to grow";
  }
  if (!test.known_failure.empty()) return result.holds(test) ? "ok, no longer a known failure" : "known failure";
  return result.holds(test) ? "ok" : "FAILS";
}

nlohmann::ordered_json finite_number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

void write_physics_text(std::ostream& out, std::span<const PhysicsCase> cases, std::span<const CaseRuns> results) {
  constexpr int width = 11;
  int names = 4;
  for (const PhysicsCase& test : cases) names = std::max(names, static_cast<int>(test.name.size()));
  const bool refined = std::any_of(results.begin(), results.end(), [](const CaseRuns& r) { return r.own.size() > 1; });
  out << std::left << std::setw(names) << "case" << std::right;
  for (const char* title : {"right", "value", "unit", "error", "limit", "dt", "ms", "at 1/60"})
    out << std::setw(width) << title;
  if (refined) {
    for (std::size_t i = 1; i < refinements.size(); ++i) {
      out << std::setw(width) << "dt / " + std::to_string(refinements[i]);
    }
  }
  out << "\n";
  std::size_t ok = 0, known = 0, fails = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const PhysicsCase& test = cases[i];
    const PhysicsResult& result = results[i].own.front();
    (result.holds(test) ? ok : test.known_failure.empty() ? fails : known)++;
    out << std::left << std::setw(names) << test.name << std::right;
    for (const std::string& text :
         {significant(test.right, 4), significant(result.value, 4), test.unit.empty() ? std::string("-") : test.unit,
          significant(result.error, 2), significant(test.limit, 2), "1/" + significant(1 / test.dt, 4),
          significant(1e3 * result.seconds, 3), significant(results[i].by_default.error, 2)}) {
      out << std::setw(width) << text;
    }
    for (std::size_t k = 1; refined && k < refinements.size(); ++k) {
      out << std::setw(width) << (k < results[i].own.size() ? significant(results[i].own[k].error, 2) : "-");
    }
    out << "  " << physics_status(test, results[i].own) << "\n";
  }
  out << "\n";
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!cases[i].known_failure.empty()) out << cases[i].name << ": " << cases[i].known_failure << "\n";
    if (refined && !cases[i].known_growth.empty()) {
      out << cases[i].name << " grows in finer steps: " << cases[i].known_growth << "\n";
    }
  }
  out << cases.size() << (cases.size() == 1 ? " case: " : " cases: ") << ok << " hold, " << fails << " fail, " << known
      << " are known to fail\n";
}

void write_physics_json(std::ostream& out, std::span<const PhysicsCase> cases, std::span<const CaseRuns> results) {
  using Json = nlohmann::ordered_json;
  Json array = Json::array();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const PhysicsCase& test = cases[i];
    Json runs = Json::array();
    for (std::size_t k = 0; k < results[i].own.size(); ++k) {
      runs.push_back({{"dt", test.dt / refinements[k]},
                      {"value", finite_number(results[i].own[k].value)},
                      {"error", finite_number(results[i].own[k].error)},
                      {"seconds", results[i].own[k].seconds}});
    }
    Json object = {{"name", test.name},   {"what", test.what},
                   {"unit", test.unit},   {"right", test.right},
                   {"scale", test.scale}, {"source", test.source},
                   {"limit", test.limit}, {"status", physics_status(test, results[i].own)}};
    if (!test.known_failure.empty()) object["known_failure"] = test.known_failure;
    if (!test.known_growth.empty()) object["known_growth"] = test.known_growth;
    object["error_by_default"] = finite_number(results[i].by_default.error);
    object["runs"] = std::move(runs);
    array.push_back(std::move(object));
  }
  const Json object = {{"format", "atoll-physics"}, {"version", 1}, {"cases", std::move(array)}};
  out << object.dump(2) << '\n';
}

}  // namespace atl::command
