// Targets for errors: what --target takes, and what a run tells of it.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/command.h"

namespace atl::test {
namespace {

using TargetJson = nlohmann::ordered_json;

CommandResult run_stack(std::vector<std::string> more) {
  std::vector<std::string> arguments = {"run", "stack:height=4", "--steps", "60", "--threads", "1"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_atoll(arguments);
}

TargetJson json_of_stack(std::vector<std::string> more) {
  more.insert(more.end(), {"--format", "json"});
  const CommandResult result = run_stack(std::move(more));
  EXPECT_EQ(result.status, 0) << result.err;
  return TargetJson::parse(result.out);
}

TEST(CommandTarget, ALengthIsOfPenetrationsAndGaps) {
  for (const char* length : {"0.1mm", "100um", "0.0001", "1e-4m", "0.1 mm"}) {
    const TargetJson settings = json_of_stack({"--target", length})["settings"];
    EXPECT_EQ(settings["target"],
              TargetJson::parse(R"({"penetration": 1e-4, "joint_gap": 1e-4, "min_substeps": 1, "max_substeps": 128})"))
        << length;
  }
  EXPECT_EQ(json_of_stack({})["settings"]["target"], "off");
}

TEST(CommandTarget, AListIsOfEachByItself) {
  const TargetJson settings =
      json_of_stack({"--target", "motion=50mm/s,penetration=1mm,residual=0.01", "--max-substeps", "16"})["settings"];
  EXPECT_EQ(settings["target"],
            TargetJson::parse(R"({"penetration": 0.001, "residual": 0.01, "motion": 0.05, "min_substeps": 1,
                                  "max_substeps": 16})"));
  EXPECT_EQ(json_of_stack({"--target", "joint_gap=0.002"})["settings"]["target"]["joint_gap"], 0.002);
}

TEST(CommandTarget, WhatItIsHeldByIsTold) {
  const TargetJson held = json_of_stack({"--target", "0.1mm"});
  EXPECT_EQ(held["missed_targets"], TargetJson::array());
  EXPECT_EQ(held["target"]["missed_steps"].get<int>() == 0, held["target"]["missed_targets"].get<int>() == 0);
  EXPECT_GT(held["target"]["mean_substeps"], 1.0);
  EXPECT_LE(held["target"]["mean_substeps"], held["target"]["max_substeps"].get<double>());
  EXPECT_LE(held["errors"]["penetration_p99"], 1e-4);
  EXPECT_EQ(held["counts"]["island_bodies"], 4);
  const std::string text = run_stack({"--target", "0.1mm"}).out;
  for (const char* words : {"substeps by target, 1 iteration", "target    0.1 mm, with 1 to 128 substeps an island",
                            "substeps for the target\n", "a body of an island got "}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  }

  const TargetJson none = json_of_stack({});
  EXPECT_FALSE(none.contains("target") || none.contains("missed_targets"));
  EXPECT_EQ(run_stack({}).out.find("target"), std::string::npos);
  EXPECT_EQ(json_of_stack({"--target", "off"})["hash"], none["hash"]);
}

TEST(CommandTarget, WhatIsNotHeldIsTold) {
  const std::vector<std::string> hopeless = {"--target", "penetration=1um", "--max-substeps", "3"};
  const TargetJson json = json_of_stack(hopeless);
  EXPECT_EQ(json["target"]["max_substeps"], 3);
  EXPECT_GT(json["target"]["missed_steps"], 30);
  ASSERT_EQ(json["missed_targets"].size(), 1u);
  const TargetJson& island = json["missed_targets"][0];
  EXPECT_EQ(island["lowest_body"], 1);
  EXPECT_EQ(island["bodies"], 4);
  EXPECT_EQ(island["contacts"], 4);
  EXPECT_EQ(island["joints"], 0);
  EXPECT_EQ(island["error"], "penetration");
  EXPECT_GT(island["measured"], 1e-6);
  EXPECT_EQ(island["target"], 1e-6);
  EXPECT_EQ(island["unit"], "m");
  EXPECT_EQ(island["substeps"], 3);
  EXPECT_EQ(island["why"], "it has the most substeps that it may get");
  const std::string text = run_stack(hopeless).out;
  for (const char* words : {"target    penetration 0.001 mm, with 1 to 3 substeps an island", " and 3 at most;",
                            " of 60 ended with an island not held, ", "not held in the last step\n    of body 1",
                            "4 dynamic bodies, 4 contacts, 0 joints: penetration ",
                            " mm, target 0.001 mm, in 3 substeps: it has the most substeps that it may get"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  }
}

TEST(CommandTarget, WhatASceneAsksForCanBeChanged) {
  const ScratchDirectory scratch;
  const std::string scene = scratch.write("held.json", R"({"format": "atoll-scene", "version": 1, "steps": 2,
    "settings": {"target": {"motion": 0.1, "min_substeps": 3, "max_substeps": 9}},
    "bodies": [{"shape": {"type": "sphere", "radius": 1}}]})");
  const auto target_with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"run", scene, "--format", "json"});
    return TargetJson::parse(run_atoll(more).out)["settings"]["target"];
  };
  EXPECT_EQ(target_with({}), TargetJson::parse(R"({"motion": 0.1, "min_substeps": 3, "max_substeps": 9})"));
  EXPECT_EQ(target_with({"--target", "penetration=1mm"}),
            TargetJson::parse(R"({"penetration": 0.001, "min_substeps": 3, "max_substeps": 9})"));
  EXPECT_EQ(target_with({"--max-substeps", "40"})["max_substeps"], 40);
  // The least number of substeps drops to the most that is allowed.
  EXPECT_EQ(target_with({"--max-substeps", "2"})["min_substeps"], 2);
  EXPECT_EQ(target_with({"--target", "off"}), "off");
}

TEST(CommandTarget, WhatMakesNoSenseIsRefused) {
  const struct {
    const char* value;
    const char* found;
    const char* expected;
  } cases[] = {
      {"1km", "found \"1km\"", "a length as 1mm or 0.001, off, or a list of penetration="},
      {"", "found \"\"", "a length as 1mm"},
      {"0", "found \"0\"", "a length as 1mm"},
      {"-1mm", "found \"-1mm\"", "a length as 1mm"},
      {"inf", "found \"inf\"", "a length as 1mm"},
      {"1mm/s", "found \"1mm/s\"", "a length as 1mm"},
      {"penetration", "penetration: found \"\"", "a length above 0"},
      {"penetration=0mm", "penetration: found \"0mm\"", "a length above 0"},
      {"joint_gap=1mm/s", "joint_gap: found \"1mm/s\"", "a length above 0"},
      {"residual=1mm", "residual: found \"1mm\"", "a finite number > 0"},
      {"motion=1mm", "motion: found \"1mm\"", "a speed above 0, as 1mm/s"},
      {"penetration=1mm,penetration=2mm", "found penetration twice", "once"},
      {"penetration=1mm,", "found \"\"", "a list of penetration="},
      {"gap=1mm", "found \"gap=1mm\"", "a list of penetration="},
  };
  for (const auto& refused : cases) {
    SCOPED_TRACE(refused.value);
    expect_refused(run_stack({"--target", refused.value}), 2, {"--target", refused.found, refused.expected});
  }
  expect_refused(run_stack({"--max-substeps", "4"}), 2, {"--max-substeps: found no target", "expected --target"});
  expect_refused(run_stack({"--target", "1mm", "--max-substeps", "0"}), 2, {"an integer in [1, 1024]"});
  expect_refused(run_stack({"--target", "1mm", "--stabilisation", "baumgarte"}), 2,
                 {"target is set with rigid stabilisation", "expected Soft"});
  expect_refused(run_stack({"--target", "1mm", "--joint-hertz", "30"}), 2, {"target.joint_gap", "joint_hertz"});
}

}  // namespace
}  // namespace atl::test
