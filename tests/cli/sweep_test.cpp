// Measurements and files of a sweep, and the options that it refuses.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/command.h"
#include "cli/driver_script.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

// Options that leave one place on each axis but for those that are named.
Words sweep_of(const Words& scenes, const std::string& out, const Words& more = {}) {
  Words words = {"sweep"};
  words.insert(words.end(), scenes.begin(), scenes.end());
  const Words single = words_of(
      "--substeps 4 --iterations 1 --dt 1/60 --friction cone --warm-start on --relax-iterations 1 --threads 1 "
      "--simd auto --tolerance 0 --target off --stabilisation soft --steps 12 --repeats 2 --time 1e-6");
  for (std::size_t i = 0; i < single.size(); i += 2) {
    if (std::find(more.begin(), more.end(), single[i]) == more.end()) {
      words.insert(words.end(), {single[i], single[i + 1]});
    }
  }
  words.insert(words.end(), more.begin(), more.end());
  words.insert(words.end(), {"--out", out});
  return words;
}

Json results_in(const std::string& directory) { return Json::parse(read_text(directory + "/results.json")); }

const Json& run_named(const Json& scene, const std::string& engine, const std::string& label) {
  for (const Json& run : scene["runs"]) {
    if (run["engine"] == engine && run["label"] == label) return run;
  }
  throw std::runtime_error("no run of " + engine + " named " + label);
}

const Json& comparison_by(const Json& scene, const std::string& measure) {
  for (const Json& comparison : scene["comparisons"]) {
    if (comparison["measure"] == measure) return comparison;
  }
  throw std::runtime_error("no comparison by " + measure);
}

Words cells_of(const std::string& line) {
  Words cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

TEST(CommandSweep, RunsTheGridOnceEachAndTheDefaultFirst) {
  const ScratchDirectory scratch;
  const CommandResult result = run_atoll(
      sweep_of({"stack:height=2"}, scratch.path("out"),
               words_of("--substeps 2,4 --iterations 1,2 --dt 1/30,1/60 --friction cone,pyramid --warm-start on,off "
                        "--relax-iterations 0,1 --threads 1,2")));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  Words labels;
  for (const Json& run : scene["runs"]) labels.push_back(run["label"]);
  EXPECT_EQ(labels, (Words{"default", "2 substeps", "2 substeps, 2 iterations", "2 iterations", "dt 1/30 s",
                           "friction pyramid", "warm start off", "0 relax iterations", "2 threads"}));
  EXPECT_TRUE(scene["runs"][0]["default"]);
  EXPECT_FALSE(scene["runs"][1]["default"]);
  EXPECT_EQ(scene["steps"], 12);
  EXPECT_EQ(scene["scene_steps"], 600);

  // The same time in steps twice as long.
  const Json& coarse = run_named(scene, "Atoll", "dt 1/30 s");
  EXPECT_EQ(coarse["steps"], 6);
  EXPECT_DOUBLE_EQ(coarse["dt"], 1.0 / 30);
  EXPECT_EQ(run_named(scene, "Atoll", "2 substeps, 2 iterations")["options"]["substeps"], 2);
  // Threads change no bit, and so are no run to compare errors of.
  EXPECT_TRUE(run_named(scene, "Atoll", "2 threads")["same_bits"]);
  EXPECT_EQ(run_named(scene, "Atoll", "2 threads")["hash"], scene["runs"][0]["hash"]);
  EXPECT_NE(run_named(scene, "Atoll", "2 substeps")["hash"], scene["runs"][0]["hash"]);
  for (const Json& run : scene["runs"]) {
    EXPECT_EQ(run["outcome"], "done");
    EXPECT_GT(run["cpu_s_per_simulated_s"]["median"], 0);
    EXPECT_EQ(run["cpu_s_per_simulated_s"]["runs"], 2);
    EXPECT_LE(run["cpu_s_per_simulated_s"]["min"], run["cpu_s_per_simulated_s"]["median"]);
    EXPECT_LE(run["cpu_s_per_simulated_s"]["median"], run["cpu_s_per_simulated_s"]["max"]);
  }
}

TEST(CommandSweep, StabilisationsAreALineAndTolerancesOneThroughTheMostIterations) {
  const ScratchDirectory scratch;
  const CommandResult result = run_atoll(sweep_of(
      {"stack:height=2"}, scratch.path("out"),
      {"--iterations", "4,1", "--stabilisation", "soft,baumgarte,split_impulse", "--tolerance", "0,0.01,1e-3"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  Words labels;
  for (const Json& run : scene["runs"]) labels.push_back(run["label"]);
  EXPECT_EQ(labels, (Words{"default", "4 iterations", "baumgarte", "split_impulse", "4 iterations, tolerance 0.01 m/s",
                           "4 iterations, tolerance 0.001 m/s"}));
  const Json& options = run_named(scene, "Atoll", "4 iterations, tolerance 0.001 m/s")["options"];
  EXPECT_EQ(options["tolerance"], 0.001);
  EXPECT_EQ(options["iterations"], 4);
  EXPECT_EQ(run_named(scene, "Atoll", "baumgarte")["options"]["stabilisation"], "baumgarte");
  EXPECT_FALSE(run_named(scene, "Atoll", "baumgarte")["same_bits"]);
}

TEST(CommandSweep, JointsHaveSolversAndNoAxesOfContactsWhereNothingTouches) {
  const ScratchDirectory scratch;
  const CommandResult result =
      run_atoll(words_of("sweep chain:links=3,ratio=2 --joint-solver auto,iterative,direct --target off --substeps 2,4 "
                         "--dt 1/60 --warm-start on "
                         "--relax-iterations 1 --threads 1 --simd auto --steps 30 --repeats 1 --time 1e-6 --out " +
                         scratch.path("out")));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  Words labels;
  for (const Json& run : scene["runs"]) labels.push_back(run["label"]);
  EXPECT_EQ(labels, (Words{"default", "2 substeps", "2 substeps, iterative joints", "iterative joints",
                           "2 substeps, direct joints", "direct joints"}));
  EXPECT_EQ(run_named(scene, "Atoll", "direct joints")["options"]["joint_solver"], "direct");
  EXPECT_EQ(scene["comparisons"][0]["measure"], "joint_gap_run_mean");
  EXPECT_EQ(scene["comparisons"][0]["unit"], "m");
  const auto gap = [&](const char* label) -> double {
    return run_named(scene, "Atoll", label)["errors"]["joint_gap_run_mean"];
  };
  EXPECT_GT(gap("iterative joints"), 0);
  EXPECT_GT(gap("2 substeps, iterative joints"), gap("iterative joints"));
  EXPECT_LT(gap("direct joints"), gap("iterative joints"));
}

TEST(CommandSweep, WhatMakesNoDifferenceIsLeftOut) {
  const ScratchDirectory scratch;
  const auto labels_of = [&](const char* scene) {
    const CommandResult result =
        run_atoll(words_of("sweep " + std::string(scene) +
                           " --substeps 4,8 --target off --dt 1/60 --threads 1 --simd auto --steps 3 "
                           "--repeats 1 --time 1e-6 --out " +
                           scratch.path("out")));
    EXPECT_EQ(result.status, 0) << result.err;
    const Json scene_results = results_in(scratch.path("out"))["scenes"][0];
    Words labels;
    for (const Json& run : scene_results["runs"]) labels.push_back(run["label"]);
    return labels;
  };
  // The default solves all of these at once, in no sweeps.
  EXPECT_EQ(labels_of("chain:links=3,ratio=100"),
            (Words{"default", "8 substeps", "iterative joints", "8 substeps, iterative joints"}));
  // So many loops are not solved at once.
  EXPECT_EQ(labels_of("joint-grid:n=20"), (Words{"default", "4 iterations", "8 substeps", "8 substeps, 4 iterations",
                                                 "warm start off", "0 relax iterations", "2 relax iterations"}));
}

TEST(CommandSweep, TargetsAreALineOfTheirOwn) {
  const ScratchDirectory scratch;
  ASSERT_EQ(run_atoll(sweep_of({"stack:height=4"}, scratch.path("out"),
                               {"--substeps", "1,16", "--target", "off,10mm,1e-3,0.0001", "--steps", "40"}))
                .status,
            0);
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  Words labels;
  for (const Json& run : scene["runs"]) labels.push_back(run["label"]);
  EXPECT_EQ(labels, (Words{"default", "1 substep", "16 substeps", "target 10 mm", "target 1 mm", "target 0.1 mm"}));
  EXPECT_EQ(scene["runs"][0]["options"]["target"], "off");
  const Json& finest = run_named(scene, "Atoll", "target 0.1 mm");
  EXPECT_EQ(finest["options"]["target"], "1e-04");
  EXPECT_FALSE(finest["same_bits"]);
  EXPECT_LE(finest["errors"]["penetration_p99"], 1e-4);
  EXPECT_LT(finest["errors"]["penetration_mean"],
            run_named(scene, "Atoll", "target 10 mm")["errors"]["penetration_mean"]);
  const CommandResult refused = run_atoll({"sweep", "stack", "--target", "1mm,fine"});
  expect_refused(refused, 2, {"--target", "found \"fine\"", "a length above 0, as 1mm or 0.001, or off"});
}

// A target has nothing to decide in a scene that sets the stiffness of its contacts itself.
TEST(CommandSweep, TargetsAreLeftOutWhereAScenesSettingsContradict) {
  const ScratchDirectory scratch;
  const std::string scene = scratch.write("stiff.json", R"({"format": "atoll-scene", "version": 1,
    "settings": {"contact_hertz": 30}, "bodies": [{"shape": {"type": "sphere", "radius": 1}},
    {"type": "static", "shape": {"type": "half_space", "offset": -1}}]})");
  for (const std::string& each : {scene, std::string("stack:height=1")}) {
    ASSERT_EQ(
        run_atoll({"sweep", each, "--quick", "--simd", "auto", "--steps", "3", "--out", scratch.path("out")}).status,
        0);
    const Json results = results_in(scratch.path("out"))["scenes"][0];
    const auto has_target = [](const Json& run) { return run["options"]["target"] != "off"; };
    EXPECT_EQ(std::count_if(results["runs"].begin(), results["runs"].end(), has_target), each == scene ? 0 : 1) << each;
  }
}

TEST(CommandSweep, JointsThatOpenByMoreThanAMetreBreakARun) {
  const ScratchDirectory scratch;
  const CommandResult result =
      run_atoll(sweep_of({"chain:links=3"}, scratch.path("out"),
                         {"--joint-solver", "auto", "--peer", write_driver(scratch, "Mock"), "--peer-limit", "1"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  const Json& apart = run_named(scene, "Mock", "default");
  EXPECT_EQ(apart["outcome"], "came_apart");
  EXPECT_EQ(apart["why"], "came apart: a joint opened by 2.0 m");
  EXPECT_FALSE(apart["cpu_s_per_simulated_s"].is_null());
  EXPECT_EQ(run_named(scene, "Mock", "better")["outcome"], "done");
  // Runs that came apart are on no front.
  const Json& front = comparison_by(scene, "joint_gap_run_max")["peer_front"];
  ASSERT_EQ(front.size(), 1u);
  EXPECT_EQ(scene["runs"][front[0].get<std::size_t>()]["label"], "better");
}

TEST(CommandSweep, ErrorsAreThoseOfTheRunCommand) {
  const ScratchDirectory scratch;
  ASSERT_EQ(run_atoll(sweep_of({"stack:height=3"}, scratch.path("out"))).status, 0);
  const CommandResult run = run_atoll({"run", "stack:height=3", "--steps", "12", "--errors", "--format", "json"});
  ASSERT_EQ(run.status, 0) << run.err;
  const Json own = results_in(scratch.path("out"))["scenes"][0]["runs"][0], expected = Json::parse(run.out);
  EXPECT_EQ(own["hash"], expected["hash"]);
  EXPECT_GT(own["errors"]["sink_max"], 0);
  for (const char* name : {"penetration_max", "penetration_mean", "sink_max", "tilt_max", "energy_drift"}) {
    EXPECT_EQ(own["errors"][name], expected["errors"][name]) << name;
  }
  EXPECT_EQ(own["errors"]["contact_residual_max"], expected["errors"]["contact_residual_max"]);
  EXPECT_LE(own["errors"]["contact_residual_median"], own["errors"]["contact_residual_max"]);
}

TEST(CommandSweep, MoreSubstepsMeanLessOverlap) {
  const ScratchDirectory scratch;
  ASSERT_EQ(
      run_atoll(sweep_of({"stack:height=2"}, scratch.path("out"), {"--substeps", "2,8", "--steps", "300"})).status, 0);
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  const double few = run_named(scene, "Atoll", "2 substeps")["errors"]["penetration_mean"];
  const double many = run_named(scene, "Atoll", "8 substeps")["errors"]["penetration_mean"];
  // Contacts stiffen with the square of the substeps: 16 times.
  EXPECT_GT(few / many, 10);
  EXPECT_LT(few / many, 22);
}

TEST(CommandSweep, SameErrorsTwice) {
  const ScratchDirectory scratch;
  const Words more = {"--substeps", "1,4", "--friction", "cone,pyramid", "--seed", "7"};
  Json results[2];
  for (int i = 0; i < 2; ++i) {
    const std::string out = scratch.path("out" + std::to_string(i));
    ASSERT_EQ(run_atoll(sweep_of({"pile:bodies=6", "stack:height=2"}, out, more)).status, 0);
    results[i] = results_in(out);
    for (Json& scene : results[i]["scenes"]) {
      scene.erase("comparisons");
      for (Json& run : scene["runs"]) {
        run.erase("cpu_s_per_simulated_s");
        run.erase("ms_per_step");
      }
    }
  }
  EXPECT_EQ(results[0].dump(), results[1].dump());
  EXPECT_TRUE(results[0]["scenes"][0]["chaotic"]);
  EXPECT_FALSE(results[0]["scenes"][1]["chaotic"]);
}

TEST(CommandSweep, CsvHoldsTheSameFigures) {
  const ScratchDirectory scratch;
  ASSERT_EQ(run_atoll(sweep_of({"stack:height=2", "pile:bodies=3"}, scratch.path("out"), {"--substeps", "2,4"})).status,
            0);
  const Words lines = lines_of(read_text(scratch.path("out") + "/results.csv"));
  ASSERT_EQ(lines.size(), 5u);
  const Words head = cells_of(lines[0]);
  const auto column = [&](const std::string& name) {
    const auto found = std::find(head.begin(), head.end(), name);
    EXPECT_NE(found, head.end()) << name;
    return static_cast<std::size_t>(found - head.begin());
  };
  const Json results = results_in(scratch.path("out"));
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const Words cells = cells_of(lines[i]);
    ASSERT_EQ(cells.size(), head.size()) << lines[i];
    const Json& scene = results["scenes"][(i - 1) / 2];
    const Json& run = scene["runs"][(i - 1) % 2];
    EXPECT_EQ(cells[column("scene")], scene["name"]);
    EXPECT_EQ(cells[column("substeps")], run["options"]["substeps"].dump());
    EXPECT_EQ(std::stod(cells[column("penetration_mean")]), run["errors"]["penetration_mean"]);
    EXPECT_EQ(std::stod(cells[column("cpu_s_per_simulated_s")]), run["cpu_s_per_simulated_s"]["median"]);
    EXPECT_EQ(cells[column("sink_max")].empty(), scene["chaotic"].get<bool>());
  }
}

TEST(CommandSweep, FilesAreWholeAndAlone) {
  const ScratchDirectory scratch;
  const std::string out = scratch.path("deep/down");
  const CommandResult result = run_atoll(sweep_of({"stack:height=1"}, out));
  ASSERT_EQ(result.status, 0) << result.err;
  Words names;
  for (const auto& entry : std::filesystem::directory_iterator(out)) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (Words{"index.html", "results.csv", "results.json"}));
  const std::string page = read_text(out + "/index.html");
  EXPECT_TRUE(page.ends_with("</html>\n"));
  EXPECT_NE(result.out.find("stack:height=1,ratio=1"), std::string::npos);
  EXPECT_NE(result.out.find("No other engine to compare with."), std::string::npos) << result.out;
}

TEST(CommandSweep, DriversAreRunAndTheirEndsTold) {
  const ScratchDirectory scratch;
  const std::string driver = write_driver(scratch, "Mock");
  const CommandResult result =
      run_atoll(sweep_of({"stack:height=2"}, scratch.path("out"), {"--peer", driver, "--peer-limit", "1"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json results = results_in(scratch.path("out"));
  EXPECT_EQ(results["engines"][1], (Json{{"name", "Mock"}, {"version", "7.1"}, {"precision", "single"}}));
  const Json& scene = results["scenes"][0];
  const struct {
    const char* label;
    const char* outcome;
    const char* why;
    bool timed;
  } expected[] = {{"default", "done", "", true},
                  {"better", "done", "", true},
                  {"toppling", "fell", "fell", true},
                  {"breaking", "non_finite", "became non-finite: Mock: body 1 is not finite", false},
                  {"endless", "too_slow", "took longer than 1 s", false},
                  {"odd</script><b>", "failed", "nonsense", false}};
  for (const auto& run : expected) {
    SCOPED_TRACE(run.label);
    const Json& found = run_named(scene, "Mock", run.label);
    EXPECT_EQ(found["outcome"], run.outcome);
    EXPECT_NE(found["why"].get<std::string>().find(run.why), std::string::npos) << found["why"];
    EXPECT_EQ(found["cpu_s_per_simulated_s"].is_null(), !run.timed);
  }
  EXPECT_EQ(run_named(scene, "Mock", "default")["cpu_s_per_simulated_s"]["median"], 2);
  EXPECT_EQ(run_named(scene, "Mock", "better")["errors"]["penetration_mean"], 0);
  EXPECT_TRUE(run_named(scene, "Mock", "default")["default"]);
}

// A file with a tower of unit boxes that is left to sweeps.
std::string write_stack(const ScratchDirectory& scratch, int height) {
  Json scene = {{"format", "atoll-scene"},
                {"version", 1},
                {"starts_at_rest", true},
                {"settings", {{"contact_solver", "iterative"}}}};
  scene["bodies"].push_back({{"type", "static"}, {"shape", {{"type", "half_space"}}}});
  for (int i = 0; i < height; ++i) {
    scene["bodies"].push_back(
        {{"shape", {{"type", "box"}, {"half_extents", {0.5, 0.5, 0.5}}}}, {"position", {0, 0, i + 0.5}}});
  }
  const std::string path = scratch.path("tower.json");
  std::ofstream(path) << scene;
  return path;
}

TEST(CommandSweep, FrontsAndVerdictsFollowFromTheFigures) {
  const ScratchDirectory scratch;
  const std::string driver = write_driver(scratch, "Mock");
  const std::string stack = write_stack(scratch, 2);
  ASSERT_EQ(run_atoll(sweep_of({stack}, scratch.path("out"),
                               {"--substeps", "1,4,16", "--peer", driver, "--peer-limit", "1", "--steps", "120"}))
                .status,
            0);
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  const Json& runs = scene["runs"];
  const Json& comparison = scene["comparisons"][0];
  EXPECT_EQ(comparison["measure"], "penetration_mean");
  EXPECT_EQ(comparison["unit"], "m");

  const auto place = [&](const std::string& engine, const std::string& label) {
    return static_cast<std::size_t>(&run_named(scene, engine, label) - &runs[0]);
  };
  // Runs that fell, broke or were too slow are on no front.
  EXPECT_EQ(comparison["peer_front"], (Json{place("Mock", "default"), place("Mock", "better")}));
  double time = 0, error = INFINITY;
  for (const Json& index : comparison["atoll_front"]) {
    const Json& run = runs[index.get<std::size_t>()];
    EXPECT_GT(run["cpu_s_per_simulated_s"]["median"], time);
    EXPECT_LT(run["errors"]["penetration_mean"], error);
    time = run["cpu_s_per_simulated_s"]["median"];
    error = run["errors"]["penetration_mean"];
  }
  // The mock takes seconds for what Atoll does in less than one, and only its better setting has no more error.
  EXPECT_EQ(comparison["verdict"]["kind"], "on_front");
  EXPECT_EQ(comparison["verdict"]["rival"], place("Mock", "better"));
  EXPECT_NE(comparison["verdict"]["text"].get<std::string>().find("(1 of the other engines' settings"),
            std::string::npos);
  const Json& match = comparison["fastest_other_at_no_more_error"][0];
  EXPECT_EQ(match["run"], place("Mock", "better"));
  EXPECT_DOUBLE_EQ(match["time_ratio"], 4 / runs[0]["cpu_s_per_simulated_s"]["median"].get<double>());
  // Nothing of Atoll's is without error.
  EXPECT_TRUE(comparison["fastest_other_at_no_more_error"][place("Mock", "better")].is_null());
  // It does not tell the residual.
  EXPECT_EQ(comparison_by(scene, "contact_residual_max")["verdict"]["kind"], "alone");
}

TEST(CommandSweep, ABetterEngineIsNamed) {
  const ScratchDirectory scratch;
  const CommandResult result =
      run_atoll(sweep_of({"stack:height=2"}, scratch.path("out"),
                         {"--peer", write_driver(scratch, "Swift"), "--peer-limit", "1", "--steps", "120"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  const Json& verdict = scene["comparisons"][0]["verdict"];
  EXPECT_EQ(verdict["kind"], "beaten");
  EXPECT_EQ(verdict["rival"], 1);
  const std::string text = verdict["text"];
  EXPECT_TRUE(text.starts_with("Swift (default) is faster than Atoll's default at no more error")) << text;
  EXPECT_NE(text.find("error none against 0.00"), std::string::npos) << text;
  EXPECT_NE(text.find("no setting of Atoll reaches that error"), std::string::npos) << text;
}

TEST(CommandSweep, RefusedScenesAreToldOnce) {
  const ScratchDirectory scratch;
  const std::string driver = write_driver(scratch, "Mock");
  const CommandResult result = run_atoll(sweep_of({"stack:height=3"}, scratch.path("out"), {"--peer", driver}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  ASSERT_EQ(scene["runs"].size(), 2u);
  EXPECT_EQ(scene["runs"][1]["outcome"], "refused");
  EXPECT_EQ(scene["runs"][1]["why"], "Mock: has no stacks of three");
  EXPECT_NE(result.out.find("has no stacks of three"), std::string::npos) << result.out;
}

TEST(CommandSweep, ADriverThatTakesLongIsNotTriedFurther) {
  const ScratchDirectory scratch;
  // One setting is stopped after 2 s; --quick gives 0.5 to all that come before another.
  const CommandResult result =
      run_atoll(sweep_of({"stack:height=2"}, scratch.path("out"),
                         {"--quick", "--peer", write_driver(scratch, "Mock"), "--peer-limit", "2"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  EXPECT_EQ(run_named(scene, "Mock", "default")["outcome"], "done");
  const Json& last = run_named(scene, "Mock", "odd</script><b>");
  EXPECT_EQ(last["outcome"], "skipped");
  EXPECT_EQ(last["why"], "not tried, as the settings before took over 0.5 s");
}

TEST(CommandSweep, ADefaultThatFellHasNoStanding) {
  const ScratchDirectory scratch;
  // At the default a tower of forty that is left to sweeps buckles; at 16 substeps it stands.
  const CommandResult result =
      run_atoll(sweep_of({write_stack(scratch, 40)}, scratch.path("out"), {"--substeps", "16", "--steps", "600"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  ASSERT_EQ(scene["runs"].size(), 2u);
  EXPECT_EQ(scene["runs"][0]["outcome"], "fell");
  EXPECT_EQ(scene["runs"][1]["outcome"], "done");
  const Json& comparison = scene["comparisons"][0];
  EXPECT_EQ(comparison["verdict"]["kind"], "no_standing");
  const std::string text = comparison["verdict"]["text"];
  EXPECT_NE(text.find("Atoll's default fell"), std::string::npos) << text;
  EXPECT_NE(text.find("of Atoll's settings: Atoll (16 substeps)"), std::string::npos) << text;
  EXPECT_EQ(comparison["atoll_front"], Json{1});
}

TEST(CommandSweep, LargeScenesGetFewerStepsAndSettings) {
  const ScratchDirectory scratch;
  const std::string driver = write_driver(scratch, "Mock");
  // 1275 boxes.
  ASSERT_EQ(run_atoll({"sweep", "wall:base=50", "--quick", "--steps", "1", "--time", "1e-6", "--peer", driver, "--out",
                       scratch.path("out")})
                .status,
            0);
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  EXPECT_TRUE(scene["large"]);
  std::size_t of_driver = 0;
  for (const Json& run : scene["runs"]) of_driver += run["engine"] == "Mock" ? 1 : 0;
  EXPECT_EQ(of_driver, 1u);
}

// A budget of steps is no reason to judge overlaps before there are any.
TEST(CommandSweep, LargeScenesThatFallRunUntilTheyHaveLanded) {
  const ScratchDirectory scratch;
  ASSERT_EQ(run_atoll({"sweep", "hopper", "--quick", "--substeps", "4", "--iterations", "1", "--time", "1e-6", "--out",
                       scratch.path("out")})
                .status,
            0);
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  EXPECT_TRUE(scene["large"]);
  EXPECT_GT(scene["steps"], 60) << "nothing touches before";
  EXPECT_LT(scene["steps"], scene["scene_steps"]);
  EXPECT_GT(scene["runs"][0]["errors"]["penetration_mean"], 1e-4);
  EXPECT_EQ(scene["comparisons"][0]["measure"], "penetration_mean");
  EXPECT_EQ(scene["comparisons"][0]["verdict"]["kind"], "alone");
}

TEST(CommandSweep, OverlapsOfWhatStillFallsAreNotJudged) {
  const ScratchDirectory scratch;
  const std::string driver = write_driver(scratch, "Mock");
  const CommandResult result = run_atoll(
      sweep_of({"hopper:bodies=20"}, scratch.path("out"), {"--steps", "10", "--peer", driver, "--peer-limit", "1"}));
  ASSERT_EQ(result.status, 0) << result.err;
  const Json scene = results_in(scratch.path("out"))["scenes"][0];
  const Json& overlaps = scene["comparisons"][0];
  EXPECT_EQ(overlaps["measure"], "penetration_mean");
  EXPECT_EQ(overlaps["verdict"]["kind"], "not_judged");
  const std::string text = overlaps["verdict"]["text"];
  EXPECT_NE(text.find("after 10 steps fewer than half of the bodies touch anything"), std::string::npos) << text;
  EXPECT_NE(result.out.find(text), std::string::npos) << result.out;
}

TEST(CommandSweep, RefusesBadArguments) {
  const ScratchDirectory scratch;
  const std::string out = scratch.path("out");
  const auto refused = [&](const Words& more, const Words& words) {
    SCOPED_TRACE(more.back());
    Words arguments = {"sweep", "stack", "--out", out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refused(run_atoll(arguments), 2, words);
  };
  refused({"--substeps", "4,x"}, {"--substeps", "found \"x\"", "an integer in [1, 1024]"});
  refused({"--substeps", "4,"}, {"--substeps", "found \"\"", "an integer in [1, 1024]"});
  refused({"--iterations", "0"}, {"--iterations", "found \"0\""});
  refused({"--dt", "1/60,1/0"}, {"--dt", "found \"1/0\"", "a number in [1e-12, 1]"});
  refused({"--dt", "nan"}, {"--dt", "found \"nan\""});
  refused({"--friction", "cone,box"}, {"--friction", "found \"box\"", "cone or pyramid"});
  refused({"--warm-start", "yes"}, {"--warm-start", "on or off"});
  refused({"--relax-iterations", "-1"}, {"--relax-iterations", "an integer in [0, 1024]"});
  refused({"--joint-solver", "auto,exact"}, {"--joint-solver", "found \"exact\"", "auto, iterative or direct"});
  refused({"--threads", "0"}, {"--threads", "an integer in [1, 1024]"});
  refused({"--simd", "mmx"}, {"--simd", "found \"mmx\"", "portable"});
  refused({"--time", "0"}, {"--time", "a number in (0, 60]"});
  refused({"--repeats", "0"}, {"--repeats", "an integer in [1, 1000]"});
  refused({"--peer-limit", "inf"}, {"--peer-limit", "a number in"});
  refused({"--peer", scratch.path("none")}, {"--peer", "none", "No such file"});
  refused({"--peer", "/bin/true"}, {"--peer", "/bin/true", "expected a JSON object"});
  refused({"--peer", "/bin/false"}, {"--peer", "/bin/false", "expected a JSON object"});
  expect_refused(run_atoll({"sweep", "--out", out}), 2, {"SCENE"});
  expect_refused(run_atoll({"sweep", "stak", "--out", out}), 3, {"did you mean \"stack\"?"});
  const std::string driver = write_driver(scratch, "Mock");
  refused({"--peer", driver, "--peer", driver}, {"--peer", "a second engine named \"Mock\""});
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(CommandSweep, DirectoryIsCheckedBeforeTheRuns) {
  const ScratchDirectory scratch;
  const std::string plain = scratch.write("plain", "kept");
  // Steps that would take days.
  const auto sweep_to = [&](const std::string& path) {
    return run_atoll(sweep_of({"pyramid3d"}, path, {"--steps", "1000000000"}));
  };
  expect_refused(sweep_to(plain), 2, {"--out", plain});
  expect_refused(sweep_to(plain + "/below"), 2, {"--out", plain, "Not a directory"});
  expect_refused(sweep_to("/proc/atoll"), 2, {"--out", "/proc/atoll"});
  EXPECT_EQ(read_text(plain), "kept");
  EXPECT_EQ(scratch.files(), Words{"plain"});
}

}  // namespace
}  // namespace atl::test
