// Output and exit status of `atoll verify`.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "checks/stability/suite.h"
#include "cli/command.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;

TEST(CommandVerify, HelpHasEveryOption) {
  const CommandResult help = run_atoll({"verify", "--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* word : {"SCENE", "--steps", "--substeps", "--threads", "--simd", "--restore", "--stability",
                           "--case NAME", "--format text|json"}) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
}

TEST(CommandVerify, RefusesWhatItCannotCheck) {
  expect_refused(run_atoll({"verify"}), 2, {"found no check to make", "a scene", "--stability", "--physics"});
  expect_refused(run_atoll({"verify", "--case", "stack-10"}), 2, {"found no check to make", "--stability"});
  expect_refused(run_atoll({"verify", "--stability", "--case", "stak-10"}), 2,
                 {"--case: found \"stak-10\"", "did you mean \"stack-10\"?"});
  expect_refused(run_atoll({"verify", "--stability", "--format", "xml"}), 2, {"--format", "text|json"});
  expect_refused(run_atoll({"verify", "--stability", "stack"}), 2, {"\"stack\"", "--stability", "expected one"});
  expect_refused(run_atoll({"verify", "--stability", "--threads", "2"}), 2, {"--threads", "SCENE"});
  expect_refused(run_atoll({"verify", "--stability", "--substeps", "2"}), 2, {"--substeps", "SCENE"});
  expect_refused(run_atoll({"verify", "stack", "--threads", "1,0"}), 2, {"--threads", "\"0\"", "[1, 1024]"});
  expect_refused(run_atoll({"verify", "stack", "--simd", "portable,mmx"}), 2, {"--simd", "\"mmx\"", "avx2"});
  expect_refused(run_atoll({"verify", "stak"}), 3, {"\"stak\"", "did you mean \"stack\"?"});
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

TEST(CommandVerify, HoldsRunsOfASceneToTheFirst) {
  const CommandResult result =
      run_atoll({"verify", "islands:count=3,base=3", "--steps", "20", "--threads", "1,3", "--simd", "portable,auto"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const std::vector<std::string> lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 10u) << result.out;
  EXPECT_EQ(lines[0], "scene     islands:count=3,base=3");
  EXPECT_EQ(lines[1], "run       20 steps of 16.67 ms");
  EXPECT_EQ(lines[3], "threads  simd      state and events");
  EXPECT_TRUE(lines[4].starts_with("      1  portable  hash 0x")) << lines[4];
  EXPECT_EQ(lines[5], "      1  auto      same after every step");
  EXPECT_EQ(lines[6], "      3  portable  same after every step");
  EXPECT_EQ(lines[7], "      3  auto      same after every step");
  EXPECT_EQ(lines[9], "3 of 3 runs are the same as the first, bit for bit");
}

TEST(CommandVerify, HoldsRunsThatAreRestoredToTheFirst) {
  const std::vector<std::string> words = {
      "verify", "islands:count=3,base=3", "--steps", "20", "--threads", "1,2", "--simd", "auto", "--restore"};
  const CommandResult result = run_atoll(words);
  EXPECT_EQ(result.status, 0) << result.err;
  const std::vector<std::string> lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 12u) << result.out;
  EXPECT_EQ(lines[3], "threads  simd      restored  state and events");
  EXPECT_TRUE(lines[4].starts_with("      1  auto      never     hash 0x")) << lines[4];
  EXPECT_EQ(lines[5], "      1  auto      same      same after every step");
  EXPECT_EQ(lines[6], "      1  auto      fresh     same after every step");
  EXPECT_EQ(lines[9], "      2  auto      fresh     same after every step");
  EXPECT_EQ(lines[11], "5 of 5 runs are the same as the first, bit for bit");
}

TEST(CommandVerify, TakesTheSettingsOfARun) {
  const auto hash = [](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"verify", "stack:height=3", "--steps", "5",        "--threads",
                                      "1",      "--simd",         "auto",    "--format", "json"};
    words.insert(words.end(), more.begin(), more.end());
    const CommandResult result = run_atoll(words);
    EXPECT_EQ(result.status, 0) << result.err;
    const Json json = Json::parse(result.out);
    EXPECT_EQ(json["format"], "atoll-determinism");
    EXPECT_EQ(json["same"], true);
    EXPECT_EQ(json["steps"], 5);
    EXPECT_EQ(json["runs"].size(), 1u) << "one alone is run again";
    return json["hash"].get<std::string>();
  };
  EXPECT_EQ(hash({}), hash({}));
  EXPECT_NE(hash({}), hash({"--substeps", "5"}));
  EXPECT_NE(hash({}), hash({"--sleeping"}));
}

CommandResult run_faulty_verify(std::vector<std::string> words) {
  words.insert(words.begin(), ATOLL_FAULTY_VERIFY_PATH);
  return run_program(words);
}

TEST(CommandVerify, NamesTheStepAndTheBodyOfAPlantedFault) {
  const CommandResult result =
      run_faulty_verify({"pile:bodies=20", "--steps", "12", "--threads", "1,2", "--simd", "portable"});
  EXPECT_EQ(result.status, 1);
  const std::vector<std::string> lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 9u) << result.out;
  EXPECT_EQ(lines[5], "      2  portable  differs in step 7: 1 body");
  EXPECT_NE(lines[6].find("body 5 \"box_0\": position by "), std::string::npos) << lines[6];
  EXPECT_NE(lines[6].find(", velocity by 1e-06 m/s"), std::string::npos) << lines[6];
  EXPECT_EQ(lines.back(), "0 of 1 runs are the same as the first, bit for bit");
  ASSERT_EQ(lines_of(result.err).size(), 1u) << result.err;
  EXPECT_NE(result.err.find("1 of 1 runs differ from the first; earliest: step 7, body 5 \"box_0\": position by "),
            std::string::npos)
      << result.err;
}

TEST(CommandVerify, TellsARunThatIsRestoredFromOthers) {
  const CommandResult result = run_faulty_verify(
      {"pile:bodies=20", "--steps", "12", "--threads", "1,2", "--simd", "portable", "--restore", "--format", "json"});
  EXPECT_EQ(result.status, 1);
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["baseline"]["restore"], "never");
  const std::vector<std::string> restores = {"same", "fresh", "never", "same", "fresh"};
  ASSERT_EQ(json["runs"].size(), restores.size());
  for (std::size_t i = 0; i < restores.size(); ++i) {
    EXPECT_EQ(json["runs"][i]["restore"], restores[i]);
    EXPECT_EQ(json["runs"][i]["same"], i < 2);
    if (i >= 2) {
      EXPECT_EQ(json["runs"][i]["divergence"]["step"], 7);
    }
  }
}

TEST(CommandVerify, JsonHasTheStepAndTheBodyOfAPlantedFault) {
  const CommandResult result = run_faulty_verify(
      {"pile:bodies=20", "--steps", "12", "--threads", "1,2,1", "--simd", "portable", "--format", "json"});
  EXPECT_EQ(result.status, 1);
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["same"], false);
  ASSERT_EQ(json["runs"].size(), 2u);
  EXPECT_EQ(json["runs"][1]["same"], true);
  const Json& run = json["runs"][0];
  EXPECT_EQ(run["threads"], 2);
  EXPECT_EQ(run["same"], false);
  EXPECT_EQ(run["divergence"]["step"], 7);
  EXPECT_EQ(run["divergence"]["seen_again"], true);
  ASSERT_EQ(run["divergence"]["bodies"].size(), 1u);
  const Json& body = run["divergence"]["bodies"][0];
  EXPECT_EQ(body["body"], 5);
  EXPECT_EQ(body["differs"][0]["part"], "position");
  EXPECT_GT(body["differs"][0]["by"], 0);
  EXPECT_EQ(body["differs"][0]["unit"], "m");
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
  EXPECT_GE(wedge["worst_step_over_median"], 1);
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
