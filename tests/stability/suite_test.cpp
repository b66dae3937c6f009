// Every case of the stability suite keeps to its limits, but for what is known to exceed them, which still does.

#include "checks/stability/suite.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "support/scenes.h"

namespace atl::stability {

// Prints a case for GoogleTest.
void PrintTo(const StabilityCase& test, std::ostream* out) { *out << test.name; }

}  // namespace atl::stability

namespace atl::test {
namespace {

using stability::CaseResult;
using stability::Criterion;
using stability::Finding;
using stability::StabilityCase;

class StabilitySuite : public testing::TestWithParam<StabilityCase> {};

TEST_P(StabilitySuite, KeepsToItsLimits) {
  const StabilityCase& test = GetParam();
  const CaseResult result = run_case(test);
  ASSERT_EQ(result.findings.size(), test.criteria.size());
  const std::string bad =
      result.bad_state ? ", without a good state from step " + std::to_string(result.bad_state->step) : std::string();
  for (const Finding& finding : result.findings) {
    const auto found = testing::Message() << test.name << " (" << test.what << "), " << finding.criterion << ": "
                                          << finding.value << " " << finding.unit << ", limit " << finding.limit << bad;
    if (finding.known_failure.empty()) {
      EXPECT_TRUE(finding.holds()) << found;
    } else {
      EXPECT_FALSE(finding.holds()) << found << ": no longer fails, so it is to be taken off the known failures ("
                                    << finding.known_failure << ")";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, StabilitySuite, testing::ValuesIn(stability::stability_cases()),
                         [](const auto& test) { return case_name(test.param.name); });

TEST(StabilityCases, HaveNamesAndLimitsOfTheirOwn) {
  std::set<std::string> names;
  for (const StabilityCase& test : stability::stability_cases()) {
    EXPECT_TRUE(names.insert(test.name).second) << test.name << " is there twice";
    EXPECT_EQ(test.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-."), std::string::npos) << test.name;
    EXPECT_FALSE(test.what.empty()) << test.name;
    EXPECT_GE(test.steps, 1) << test.name;
    EXPECT_FALSE(test.criteria.empty()) << test.name;
    for (const Criterion& criterion : test.criteria) {
      EXPECT_TRUE(criterion.limit >= 0 && std::isfinite(criterion.limit)) << test.name << ", " << criterion.name;
    }
  }
}

// A box that falls through nothing, with a limit on the speed that it has after a second.
StabilityCase falling(double limit, const std::string& known_failure = {}) {
  const auto build = [] {
    Scene scene;
    scene.bodies.push_back({.name = "box", .def = {}});
    return scene;
  };
  const auto speed = [](const stability::History& run) { return run.states.back()[0].velocity.norm(); };
  return {.name = "falling",
          .what = "a box that falls",
          .build = build,
          .steps = 60,
          .criteria = {{"speed", "m/s", limit, speed, known_failure}}};
}

TEST(RunCase, TellsWhatHoldsAndByHowMuch) {
  const CaseResult holds = run_case(falling(19.62));
  ASSERT_EQ(holds.findings.size(), 1u);
  EXPECT_NEAR(holds.findings[0].value, 9.81, 1e-5);
  EXPECT_NEAR(holds.findings[0].margin(), 2, 1e-5);
  EXPECT_FALSE(holds.failed());

  const CaseResult fails = run_case(falling(9));
  EXPECT_TRUE(fails.failed());
  EXPECT_FALSE(fails.findings[0].expected());
  EXPECT_LT(fails.findings[0].margin(), 1);

  const CaseResult known = run_case(falling(9, "gravity"));
  EXPECT_FALSE(known.failed());
  EXPECT_TRUE(known.findings[0].expected());
  EXPECT_FALSE(run_case(falling(10, "gravity")).findings[0].expected()) << "it no longer fails";
}

TEST(RunCase, NothingNonFiniteHolds) {
  StabilityCase test = falling(1e300);
  test.build = [] {
    Scene scene;
    scene.bodies.push_back({.name = "box", .def = {.mass = 1e-10}, .force = {1e300, 0, 0}});
    return scene;
  };
  const CaseResult result = run_case(test);
  ASSERT_TRUE(result.bad_state.has_value());
  EXPECT_EQ(result.bad_state->body, 0u);
  EXPECT_TRUE(result.failed());
}

}  // namespace
}  // namespace atl::test
