// What `atoll verify` prints, and how it ends.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/command.h"
#include "stability/suite.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;

TEST(CommandVerify, HelpHasEveryOption) {
  const CommandResult help = run_atoll({"verify", "--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* word : {"--stability", "--case NAME", "--format text|json"}) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
}

TEST(CommandVerify, RefusesWhatItCannotCheck) {
  expect_refused(run_atoll({"verify"}), 2, {"found no check to make", "--stability"});
  expect_refused(run_atoll({"verify", "--case", "stack-10"}), 2, {"found no check to make", "--stability"});
  expect_refused(run_atoll({"verify", "--stability", "--case", "stak-10"}), 2,
                 {"--case: found \"stak-10\"", "did you mean \"stack-10\"?"});
  expect_refused(run_atoll({"verify", "--stability", "--format", "xml"}), 2, {"--format", "text|json"});
  expect_refused(run_atoll({"verify", "--stability", "stack"}), 2, {"stack"});
}

TEST(CommandVerify, TellsACaseCriterionByCriterion) {
  const CommandResult result = run_atoll({"verify", "--stability", "--case", "wedge", "--case", "wedge-smooth"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  std::istringstream lines(result.out);
  std::string line;
  std::getline(lines, line);
  for (const char* column : {"case", "criterion", "value", "limit", "margin", "ms a step"}) {
    EXPECT_NE(line.find(column), std::string::npos) << column;
  }
  std::getline(lines, line);
  EXPECT_TRUE(line.starts_with("wedge ")) << line;
  EXPECT_NE(line.find("penetration, m"), std::string::npos) << line;
  EXPECT_TRUE(line.ends_with("  ok")) << line;
  EXPECT_NE(result.out.find("\nwedge-smooth "), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("\n2 cases: "), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("card-house"), std::string::npos) << result.out;
}

Json verify_json(const std::string& name) {
  const CommandResult result = run_atoll({"verify", "--stability", "--case", name, "--format", "json"});
  EXPECT_EQ(result.status, 0) << result.err;
  return Json::parse(result.out);
}

TEST(CommandVerify, JsonHasValuesAndLimits) {
  const Json json = verify_json("wedge");
  EXPECT_EQ(json["format"], "atoll-stability");
  EXPECT_EQ(json["ok"], 4);
  EXPECT_EQ(json["fail"], 0);
  EXPECT_EQ(json["known_failures"], 0);
  ASSERT_EQ(json["cases"].size(), 1u);
  const Json& wedge = json["cases"][0];
  EXPECT_EQ(wedge["name"], "wedge");
  EXPECT_EQ(wedge["steps"], 300);
  EXPECT_EQ(wedge["failed"], false);
  EXPECT_GT(wedge["ms_per_step"], 0);
  ASSERT_EQ(wedge["criteria"].size(), 4u);
  EXPECT_EQ(wedge["criteria"][0]["name"], "penetration");
  EXPECT_EQ(wedge["criteria"][0]["unit"], "m");
  EXPECT_EQ(wedge["criteria"][0]["limit"], 1e-3);
  for (const Json& criterion : wedge["criteria"]) {
    EXPECT_EQ(criterion["status"], "ok");
    const double value = criterion["value"], limit = criterion["limit"];
    EXPECT_LE(value, limit);
    if (value > 0) {
      EXPECT_NEAR(criterion["margin"].get<double>() * value, limit, 1e-9 * limit);
    } else {
      EXPECT_TRUE(criterion["margin"].is_null());
    }
  }
}

// The first that is known to fail.
const stability::StabilityCase* known_failure() {
  for (const stability::StabilityCase& test : stability::stability_cases()) {
    for (const stability::Criterion& criterion : test.criteria) {
      if (!criterion.known_failure.empty()) return &test;
    }
  }
  return nullptr;
}

TEST(CommandVerify, AKnownFailureIsToldAndDoesNotCount) {
  const stability::StabilityCase* known = known_failure();
  if (known == nullptr) GTEST_SKIP() << "nothing is known to fail";
  const CommandResult result = run_atoll({"verify", "--stability", "--case", known->name});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_NE(result.out.find("  known failure\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("\nknown failures, because "), std::string::npos) << result.out;
  const Json json = verify_json(known->name);
  EXPECT_GT(json["known_failures"], 0);
  EXPECT_EQ(json["cases"][0]["failed"], false);
}

}  // namespace
}  // namespace atl::test
