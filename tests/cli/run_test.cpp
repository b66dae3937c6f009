// Output and files of a run.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli/command.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> keys_of(const Json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

using Keys = std::vector<std::string>;

TEST(CommandRun, JsonHasTheKeysInTheirOrder) {
  const CommandResult result =
      run_atoll(words_of("run stack:height=3 --steps 5 --dt 0.01 --threads 2 --substeps 2 --friction pyramid "
                         "--no-warm-start --sleeping --stabilisation split_impulse --correction 0.3 --slop 1e-4 "
                         "--tolerance 1e-3 --joint-solver direct --joint-hertz 25 --format json"));
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const Json json = Json::parse(result.out);
  EXPECT_EQ(
      keys_of(json),
      (words_of("scene bodies steps dt threads simd settings ms_per_step phases_ms counts errors features hash")));
  EXPECT_EQ(keys_of(json["ms_per_step"]), (Keys{"mean", "median", "p99", "max", "longest_step"}));
  EXPECT_EQ(keys_of(json["phases_ms"]), (Keys{"plan", "find_pairs", "update_contacts", "build_islands", "solve_islands",
                                              "sweep_fast_bodies", "finish"}));
  EXPECT_EQ(keys_of(json["counts"]),
            (words_of("pairs contacts points joints islands groups colours fcl_calls fcl_repairs recycled_manifolds "
                      "recomputed_manifolds asleep id_matches id_misses swept stopped sweeps direct_joints "
                      "direct_islands refined_islands unsolved_islands refused_islands missed_targets body_substeps "
                      "island_bodies max_substeps newton_iterations discarded_iterations aabb_updates")));
  EXPECT_EQ(keys_of(json["errors"]),
            (words_of("penetration_max penetration_p99 penetration_mean penetration_max_relative sink_max sink_mean "
                      "drift_max tilt_max energy_drift")));
  for (const Json& feature : json["features"])
    EXPECT_EQ(keys_of(feature), (Keys{"name", "run", "why", "items", "unit", "ms"}));

  EXPECT_EQ(json["scene"], "stack:height=3,ratio=1");
  EXPECT_EQ(json["bodies"], 3);
  EXPECT_EQ(json["steps"], 5);
  EXPECT_EQ(json["dt"], 0.01);
  EXPECT_EQ(json["threads"], 2);
  EXPECT_NE(json["simd"], "auto");
  EXPECT_EQ(json["settings"]["substeps"], 2);
  EXPECT_EQ(json["settings"]["friction"], "pyramid");
  EXPECT_EQ(json["settings"]["warm_starting"], false);
  EXPECT_EQ(json["settings"]["sleeping"], true);
  EXPECT_EQ(json["settings"]["stabilisation"], "split_impulse");
  EXPECT_EQ(json["settings"]["correction"], 0.3);
  EXPECT_EQ(json["settings"]["slop"], 1e-4);
  EXPECT_EQ(json["settings"]["tolerance"], 0.001);
  EXPECT_EQ(json["settings"]["joint_solver"], "direct");
  EXPECT_EQ(json["settings"]["joint_hertz"], 25);
  EXPECT_EQ(json["settings"]["joint_damping_ratio"], 2);
  const std::string hash = json["hash"];
  EXPECT_EQ(hash.size(), 18u);
  EXPECT_EQ(hash.find_first_not_of("0123456789abcdef", 2), std::string::npos) << hash;

  const Json& ms = json["ms_per_step"];
  EXPECT_LE(ms["median"], ms["p99"]);
  EXPECT_LE(ms["p99"], ms["max"]);
  EXPECT_TRUE(ms["longest_step"] >= 1 && ms["longest_step"] <= json["steps"]);
  EXPECT_LE(ms["mean"], ms["max"]);
}

TEST(CommandRun, ProfileTellsTheSolversStagesAndChangesNothing) {
  const std::vector<std::string> plain = {"run", "stack:height=3", "--steps", "30", "--threads", "1"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), plain.begin(), plain.end());
    return run_atoll(more);
  };
  const Json profile = Json::parse(with({"--profile", "--format", "json"}).out);
  const Json without = Json::parse(with({"--format", "json"}).out);
  EXPECT_EQ(profile["hash"], without["hash"]);
  EXPECT_FALSE(without.contains("solver_ms"));
  ASSERT_TRUE(profile.contains("solver_ms"));
  EXPECT_EQ(keys_of(profile["solver_ms"]),
            (words_of("colour prepare warm_start solve relax integrate restitution store")));
  double all = 0;
  for (const char* phase : {"prepare", "solve", "relax", "integrate", "store"}) {
    EXPECT_GT(profile["solver_ms"][phase], 0) << phase;
  }
  for (const Json& ms : profile["solver_ms"]) all += ms.get<double>();
  EXPECT_LE(all, profile["phases_ms"]["solve_islands"].get<double>()) << "on one thread they are parts of the phase";
  // Nothing bounces, and Baumgarte does not relax. The least of some runs is what nothing else on the machine adds to.
  const auto min_ms = [&](const char* phase, const char* stabilisation) {
    double min = INFINITY;
    for (int i = 0; i < 5; ++i) {
      const CommandResult result = with({"--profile", "--stabilisation", stabilisation, "--format", "json"});
      min = std::min(min, Json::parse(result.out)["solver_ms"][phase].get<double>());
    }
    return min;
  };
  EXPECT_LT(min_ms("restitution", "soft"), profile["solver_ms"]["solve"]);
  EXPECT_LT(min_ms("relax", "baumgarte"), profile["solver_ms"]["solve"]);

  const std::string text = with({"--profile"}).out;
  for (const char* word : {"solver, all groups", "ns a point and substep", "warm_start", "relax", "store"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(with({}).out.find("solver, all groups"), std::string::npos);
}

TEST(CommandRun, CountsSweeps) {
  // One island in one group: 5 substeps of 3 sweeps and 2 to relax.
  const Json json = Json::parse(
      run_atoll(
          words_of("run stack:height=3 --steps 30 --substeps 5 --iterations 3 --relax-iterations 2 --format json"))
          .out);
  EXPECT_EQ(json["counts"]["sweeps"], 25);
}

TEST(CommandRun, RestErrorsAreForScenesAtRest) {
  const CommandResult result = run_atoll({"run", "pile:bodies=5", "--steps", "2", "--format", "json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(keys_of(json["errors"]), (Keys{"penetration_max", "penetration_p99", "penetration_mean",
                                           "penetration_max_relative", "energy_drift"}));
  EXPECT_EQ(json["bodies"], 5);
}

TEST(CommandRun, OutHoldsTheSameObject) {
  const ScratchDirectory scratch;
  const CommandResult result =
      run_atoll({"run", "stack", "--steps", "2", "--format", "json", "--out", scratch.path("out.json")});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(read_text(scratch.path("out.json")), result.out);
  EXPECT_EQ(scratch.files(), Keys{"out.json"});
}

TEST(CommandRun, TextEndsWithTheHash) {
  const CommandResult text = run_atoll({"run", "stack", "--steps", "2"});
  ASSERT_EQ(text.status, 0) << text.err;
  for (const char* word :
       {"stack:height=10,ratio=1", "10 dynamic, 1 static", "2 steps", "solve_islands", "median", "penetration_max",
        "largest overlap of two shapes", "tilt_max", "10 bodies moved for 0.0333 s", "times real time", "--profile",
        "--errors", "atoll sweep", "hash"}) {
    EXPECT_NE(text.out.find(word), std::string::npos) << word;
  }
  for (const char* word : {"counts of the last step", "features of the last step"}) {
    EXPECT_EQ(text.out.find(word), std::string::npos) << word;
    EXPECT_NE(run_atoll({"run", "stack", "--steps", "2", "--profile"}).out.find(word), std::string::npos) << word;
  }
  const CommandResult hash = run_atoll({"run", "stack", "--steps", "2", "--hash"});
  const std::string last = lines_of(hash.out).back();
  EXPECT_TRUE(last.starts_with("0x") && last.size() == 18) << last;
  EXPECT_TRUE(lines_of(text.out).back().ends_with(last));
}

TEST(CommandRun, SeedChangesThePile) {
  const auto last_line = [](const char* seed) {
    return lines_of(run_atoll({"run", "pile:bodies=5", "--steps", "1", "--hash", "--seed", seed}).out).back();
  };
  EXPECT_EQ(last_line("5"), last_line("5"));
  EXPECT_NE(last_line("5"), last_line("6"));
}

TEST(CommandRun, FinalStateIsCsvThatReadsBackExactly) {
  const ScratchDirectory scratch;
  const std::string scene = scratch.write("named.json", R"({"format": "atoll-scene", "version": 1, "gravity": [0, 0, 0],
    "bodies": [{"name": "a, \"b\"", "type": "static", "shape": {"type": "sphere", "radius": 1}},
               {"shape": {"type": "sphere", "radius": 1}, "position": [0.1, 1e-300, 1e11],
                "velocity": [0, 0, 0]}]})");
  const std::string csv = scratch.path("state.csv");
  const CommandResult result = run_atoll({"run", scene, "--steps", "1", "--final-state", csv});
  ASSERT_EQ(result.status, 0) << result.err;
  const std::vector<std::string> lines = lines_of(read_text(csv));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0], "id,name,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz");
  EXPECT_TRUE(lines[1].starts_with("0,\"a, \"\"b\"\"\",0,0,0,")) << lines[1];
  EXPECT_TRUE(lines[2].starts_with("1,,0.10000000000000001,")) << lines[2];

  std::vector<double> numbers;
  std::istringstream row(lines[2].substr(3));
  for (std::string cell; std::getline(row, cell, ',');) numbers.push_back(std::strtod(cell.c_str(), nullptr));
  ASSERT_EQ(numbers.size(), 13u);
  EXPECT_EQ(numbers[0], 0.1);
  EXPECT_EQ(numbers[1], 1e-300);
  EXPECT_EQ(numbers[2], 1e11);
  EXPECT_EQ(numbers[6], 1);
}

TEST(CommandRun, FilesAreCheckedBeforeTheRun) {
  const ScratchDirectory scratch;
  const std::string plain = scratch.write("plain", "kept");
  for (const std::string option : {"--final-state", "--out"}) {
    SCOPED_TRACE(option);
    // Steps that would take days.
    const auto run_to = [&](const std::string& path) {
      return run_atoll({"run", "pyramid3d", "--steps", "1000000000", option, path});
    };
    expect_refused(run_to(scratch.path("none/state")), 2, {option, "none/state", "No such file or directory"});
    expect_refused(run_to(plain + "/state"), 2, {option, "Not a directory"});
    expect_refused(run_to(scratch.path("")), 2, {option, "is a directory"});
    expect_refused(run_to("/proc/atoll"), 2, {option, "/proc/atoll"});
  }
  expect_refused(run_atoll({"run", "stack", "--out", plain, "--final-state", plain}), 2, {"--final-state", "--out"});
  EXPECT_EQ(read_text(plain), "kept");
  EXPECT_EQ(scratch.files(), Keys{"plain"});
}

TEST(CommandRun, DevicesAreWrittenNotReplaced) {
  const CommandResult result = run_atoll({"run", "stack", "--steps", "1", "--out", "/dev/null"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
  // The results are on stdout all the same where the file turns out not to take them.
  const CommandResult full = run_atoll({"run", "stack", "--steps", "1", "--out", "/dev/full"});
  EXPECT_EQ(full.status, 2);
  EXPECT_NE(full.err.find("No space left"), std::string::npos) << full.err;
  EXPECT_NE(full.out.find("hash"), std::string::npos);
}

TEST(CommandRun, SymbolicLinksAreFollowed) {
  const ScratchDirectory scratch;
  scratch.write("target", "old");
  std::filesystem::create_symlink("target", scratch.path("link"));
  ASSERT_EQ(run_atoll({"run", "stack", "--steps", "1", "--out", scratch.path("link")}).status, 0);
  EXPECT_TRUE(std::filesystem::is_symlink(scratch.path("link")));
  EXPECT_NE(read_text(scratch.path("target")), "old");
}

TEST(CommandRun, BrokenSimulationKeepsTheLastFiniteState) {
  const ScratchDirectory scratch;
  // A body that is faster than anything after a step.
  const std::string scene = scratch.write("fast.json", R"({"format": "atoll-scene", "version": 1, "dt": 1,
    "gravity": [1e307, 0, 0], "steps": 1000,
    "bodies": [{"name": "rocket", "shape": {"type": "sphere", "radius": 1}}]})");
  const std::string csv = scratch.path("state.csv");
  const CommandResult result = run_atoll({"run", scene, "--final-state", csv});
  expect_refused(result, 4, {"body 0 \"rocket\"", "step 1 of 1000", "1e6 m/s", "--final-state", "--keep-going"});
  const std::string state = read_text(csv);
  EXPECT_EQ(lines_of(state).size(), 2u);
  EXPECT_EQ(state.find("nan"), std::string::npos) << state;
  EXPECT_EQ(state.find("inf"), std::string::npos) << state;
}

TEST(CommandRun, KeepGoingLeavesOutWhatIsLostAndListsIt) {
  const ScratchDirectory scratch;
  const std::string scene = scratch.write("lost.json", R"({"format": "atoll-scene", "version": 1, "steps": 20,
    "bodies": [{"name": "crate", "shape": {"type": "sphere", "radius": 1}},
               {"name": "rocket", "shape": {"type": "sphere", "radius": 1}, "position": [9, 0, 0], "velocity": [0, 0, 1e7]},
               {"shape": {"type": "sphere", "radius": 1}, "position": [0, 0, 2e12]}]})");
  expect_refused(run_atoll({"run", scene}), 4, {"body 1 \"rocket\"", "step 1 of 20", "1e6 m/s", "1 more"});
  const CommandResult text = run_atoll({"run", scene, "--keep-going"});
  EXPECT_EQ(text.status, 0) << text.err;
  for (const char* words : {"body 1 \"rocket\" was quarantined in step 1 of 20: its speed is above 1e6 m/s",
                            "body 2 was quarantined in step 1 of 20: it is farther than 1e12 m"}) {
    EXPECT_NE(text.out.find(words), std::string::npos) << text.out;
  }
  const Json json = Json::parse(run_atoll({"run", scene, "--keep-going", "--errors", "--format", "json"}).out);
  ASSERT_EQ(json["quarantined"].size(), 2u);
  EXPECT_EQ(json["quarantined"][0]["body"], 1);
  EXPECT_EQ(json["quarantined"][0]["step"], 1);
  EXPECT_EQ(json["counts"]["pairs"], 0);
  EXPECT_FALSE(
      Json::parse(run_atoll({"run", "stack", "--steps", "1", "--format", "json"}).out).contains("quarantined"));
}

TEST(CommandRun, ErrorsOfEveryStepAreMeasuredOnRequestAndChangeNothing) {
  const std::vector<std::string> plain = {"run", "stack:height=3", "--steps", "30", "--format", "json"};
  std::vector<std::string> with_errors = plain;
  with_errors.push_back("--errors");
  const Json without = Json::parse(run_atoll(plain).out), with = Json::parse(run_atoll(with_errors).out);
  EXPECT_FALSE(without["errors"].contains("contact_residual"));
  ASSERT_TRUE(with["errors"].contains("contact_residual"));
  // Landing: the solver's answer is not exact, but nearer than none.
  EXPECT_GT(with["errors"]["contact_residual_max"], 0.0);
  EXPECT_LT(with["errors"]["contact_residual_max"], 1.0);
  EXPECT_LE(with["errors"]["contact_residual"], with["errors"]["contact_residual_max"]);
  EXPECT_EQ(with["hash"], without["hash"]);
}

}  // namespace
}  // namespace atl::test
