// Results and output of atoll tune, and the options that it refuses.

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/command.h"

namespace atl::test {
namespace {

using TuneJson = nlohmann::ordered_json;

CommandResult run_tune(const std::string& scene, const std::string& error, std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"tune", scene, "--error", error, "--repeats", "1", "--time", "1e-6"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return run_atoll(arguments);
}

TEST(CommandTune, PrintsABlockThatASceneFileTakesAndThatHolds) {
  const ScratchDirectory scratch;
  const CommandResult found = run_tune("wall:base=5", "0.1mm", {"--steps", "120"});
  ASSERT_EQ(found.status, 0) << found.err;
  ASSERT_TRUE(found.out.starts_with("\"settings\": {\n")) << found.out;
  TuneJson scene = TuneJson::parse(run_atoll({"scenes", "wall:base=5"}).out);
  scene["settings"] = TuneJson::parse("{" + found.out + "}")["settings"];
  const std::string file = scratch.write("tuned.json", scene.dump());
  const CommandResult run = run_atoll({"run", file, "--steps", "120", "--format", "json"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_LE(TuneJson::parse(run.out)["errors"]["penetration_p99"], 1e-4);
  for (const char* words : {"substeps, contacts auto, joints auto: penetration ", " mm at rest, too much; ",
                            "% of all steps within 0.1 mm\n", "cheapest: ", " ms of CPU time a step\n"}) {
    EXPECT_NE(found.err.find(words), std::string::npos) << words << "\n" << found.err;
  }
}

TEST(CommandTune, EachPairOfSolversHasItsFewestSubsteps) {
  const CommandResult result = run_tune("bridge:planks=8", "1mm", {"--steps", "120", "--format", "json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const TuneJson found = TuneJson::parse(result.out);
  EXPECT_EQ(found["error"], 0.001);
  EXPECT_EQ(found["steps"], 120);
  const TuneJson& trials = found["trials"];
  const TuneJson& cheapest = trials[found["cheapest"].get<std::size_t>()];
  for (const char* key : {"substeps", "contact_solver", "joint_solver"})
    EXPECT_EQ(found["settings"][key], cheapest[key]);
  int timed = 0;
  for (const TuneJson& trial : trials) {
    EXPECT_EQ(trial["holds"], (trial["penetration"].get<double>() <= 1e-3 && trial["joint_gap"].get<double>() <= 1e-3))
        << trial;
    if (!trial.contains("cpu_s_per_simulated_s")) continue;
    ++timed;
    EXPECT_TRUE(trial["holds"]) << trial;
    EXPECT_LE(cheapest["cpu_s_per_simulated_s"], trial["cpu_s_per_simulated_s"]);
    // Just below it did not hold, and just above it does.
    const auto tried_by = [&](const auto& is_it) {
      return std::any_of(trials.begin(), trials.end(), [&](const TuneJson& other) {
        return other["contact_solver"] == trial["contact_solver"] && other["joint_solver"] == trial["joint_solver"] &&
               is_it(other);
      });
    };
    const int substeps = trial["substeps"];
    EXPECT_TRUE(tried_by([&](const TuneJson& other) { return other["substeps"] > substeps && other["holds"] == true; }))
        << trial;
    EXPECT_TRUE(substeps == 1 || tried_by([&](const TuneJson& other) {
                  return other["substeps"] < substeps && other["holds"] == false;
                }))
        << trial;
  }
  // Joints that are solved one by one need more substeps than those that are solved at once.
  EXPECT_GE(timed, 2);
  // Trials and their results are the same each time.
  TuneJson again = TuneJson::parse(run_tune("bridge:planks=8", "1mm", {"--steps", "120", "--format", "json"}).out);
  ASSERT_EQ(again["trials"].size(), trials.size());
  for (std::size_t i = 0; i < trials.size(); ++i) {
    for (const char* key : {"substeps", "penetration", "joint_gap", "steps_within"}) {
      EXPECT_EQ(again["trials"][i][key], trials[i][key]) << i << key;
    }
  }
}

TEST(CommandTune, WhatNothingHoldsEndsWithTheBestThatThereIs) {
  const ScratchDirectory scratch;
  // Contacts that give so far, in however many substeps.
  const std::string soft = scratch.write("soft.json", R"({"format": "atoll-scene", "version": 1, "steps": 60,
    "settings": {"contact_hertz": 3}, "bodies": [{"shape": {"type": "sphere", "radius": 1}},
    {"type": "static", "shape": {"type": "half_space", "offset": -1}}]})");
  const CommandResult none = run_tune(soft, "0.1mm");
  EXPECT_EQ(none.status, 1);
  EXPECT_EQ(none.out, "");
  for (const char* words :
       {"atoll: soft: no fixed settings of up to 64 substeps hold 0.1 mm: the best, ", " come to penetration "}) {
    EXPECT_NE(lines_of(none.err).back().find(words), std::string::npos) << words << "\n" << none.err;
  }
  const CommandResult json = run_tune(soft, "0.1mm", {"--format", "json"});
  EXPECT_EQ(json.status, 1);
  const TuneJson found = TuneJson::parse(json.out);
  EXPECT_TRUE(found["settings"].is_null() && found["cheapest"].is_null());
  EXPECT_TRUE(found["smallest_error"].is_number());
}

TEST(CommandTune, WhatASceneAimsAtIsLeftOut) {
  const ScratchDirectory scratch;
  const std::string scene = scratch.write("aims.json", R"({"format": "atoll-scene", "version": 1, "steps": 30,
    "settings": {"target": {"penetration": 1e-4}}, "bodies": [{"shape": {"type": "sphere", "radius": 1}},
    {"type": "static", "shape": {"type": "half_space", "offset": -1}}]})");
  const CommandResult found = run_tune(scene, "1mm");
  ASSERT_EQ(found.status, 0) << found.err;
  EXPECT_FALSE(TuneJson::parse("{" + found.out + "}")["settings"].contains("target"));
}

TEST(CommandTune, RefusesWhatIsNoError) {
  for (const char* wrong : {"0", "-1mm", "1kg", "", "nan", "1mm/s", "off"}) {
    expect_refused(run_tune("stack", wrong), 2, {"--error", "found \"" + std::string(wrong) + "\"", "as 1mm or 0.001"});
  }
  expect_refused(run_tune("stack", "5um"), 2, {"--error: found 0.005 mm, expected at least 0.01 mm"});
  expect_refused(run_atoll({"tune"}), 2, {"SCENE"});
  expect_refused(run_atoll({"tune", "stak"}), 3, {"unknown scene \"stak\""});
}

}  // namespace
}  // namespace atl::test
