// Help, listings and what the command does not accept.

#include <gtest/gtest.h>

#include "cli/command.h"

namespace atl::test {
namespace {

TEST(CommandUsage, VersionAndHelp) {
  const CommandResult version = run_atoll({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_TRUE(version.out.starts_with("atoll ")) << version.out;
  EXPECT_EQ(version.err, "");

  const CommandResult help = run_atoll({"--help"});
  EXPECT_EQ(help.status, 0);
  for (const std::string& word : words_of("run,replay,ensemble,import,scenes,--version,Exit status,non-finite", ',')) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
}

TEST(CommandUsage, HelpOfRunHasEveryOption) {
  const CommandResult help = run_atoll({"run", "--help"});
  EXPECT_EQ(help.status, 0);
  for (const std::string& word :
       words_of("SCENE,--steps,--dt,--threads,--substeps,--target ERROR,--max-substeps,--iterations,"
                "--relax-iterations,--friction cone|pyramid,--no-warm-start,--sleeping,"
                "--simd auto|portable|sse4|avx2|avx512,--seed,--tolerance,"
                "--stabilisation soft|baumgarte|split_impulse,--correction,--joint-solver auto|iterative|direct,"
                "--joint-hertz,--slop,--out FILE,--final-state FILE,--format text|json,--errors,--profile,--hash",
                ',')) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
}

TEST(CommandUsage, HelpOfSweepHasEveryOption) {
  const CommandResult help = run_atoll({"sweep", "--help"});
  EXPECT_EQ(help.status, 0);
  for (const std::string& word :
       words_of("SCENE,--analytic,--substeps LIST,--iterations LIST,--dt LIST,--friction LIST,--warm-start LIST,"
                "--relax-iterations LIST,--stabilisation LIST,--tolerance LIST,--threads LIST,--simd LIST,"
                "--quick,--steps,--repeats,--time,--seed,--peer PROGRAM,--peer-limit,--out DIR",
                ',')) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
}

TEST(CommandUsage, ScenesListsAllWithParameters) {
  const CommandResult scenes = run_atoll({"scenes"});
  EXPECT_EQ(scenes.status, 0);
  EXPECT_EQ(scenes.err, "");
  for (const std::string& word : words_of("pyramid3d layers wall base islands count pile bodies stack height ratio")) {
    EXPECT_NE(scenes.out.find(word), std::string::npos) << word;
  }
}

TEST(CommandUsage, RefusesBadArguments) {
  expect_refused(
      run_atoll({"walk"}), 2,
      {"unknown command \"walk\", expected run, view, explain, replay, bisect, soak, sweep, tune, ensemble, import, "
       "verify or scenes"});
  expect_refused(run_atoll({"rnu", "pile"}), 2, {"unknown command \"rnu\"", "did you mean \"run\"?"});
  expect_refused(run_atoll({"run"}), 2, {"SCENE"});
  expect_refused(run_atoll({"run", "stack", "wall"}), 2, {"wall"});
  expect_refused(run_atoll({"run", "stack", "--bogus"}), 2, {"unknown option \"--bogus\""});
  expect_refused(run_atoll({"run", "stack", "--thread", "2"}), 2,
                 {"unknown option \"--thread\"", "did you mean \"--threads\"?"});
  expect_refused(run_atoll({"run", "stack", "--threads"}), 2, {"--threads"});
}

TEST(CommandUsage, HelpIsWhatNoCommandAsksFor) {
  const CommandResult nothing = run_atoll({});
  EXPECT_EQ(nothing.status, 0);
  EXPECT_EQ(nothing.out, run_atoll({"--help"}).out);
  for (const char* command : {"run", "explain", "replay", "soak", "sweep", "tune", "verify"}) {
    EXPECT_NE(run_atoll({command, "--help"}).out.find(std::string("atoll ") + command + " "), std::string::npos)
        << "an example of " << command;
  }
}

TEST(CommandUsage, AFullOutputIsAnError) {
  for (const std::string arguments : {"scenes", "--help", "run stack --steps 1"}) {
    const CommandResult full =
        run_program({"/bin/sh", "-c", "exec \"$0\" " + arguments + " > /dev/full", ATOLL_COMMAND_PATH});
    EXPECT_EQ(full.status, 2) << arguments;
    EXPECT_NE(full.err.find("standard output"), std::string::npos) << full.err;
  }
}

TEST(CommandUsage, AFractionIsAStepLengthToo) {
  const auto hash_with = [](const char* dt) {
    return run_atoll({"run", "stack", "--steps", "3", "--dt", dt, "--hash"}).out;
  };
  const std::string fraction = hash_with("1/50"), number = hash_with("0.02");
  EXPECT_EQ(fraction.substr(fraction.size() - 20), number.substr(number.size() - 20));
}

TEST(CommandUsage, RefusesBadValues) {
  const struct {
    const char* option;
    const char* value;
    const char* expected;
  } cases[] = {
      {"--threads", "0", "an integer in [1, 1024]"},
      {"--threads", "-1", "an integer in [1, 1024]"},
      {"--threads", "two", "an integer in [1, 1024]"},
      {"--threads", "99999999999999999999", "an integer in [1, 1024]"},
      {"--steps", "0", "an integer in [1, 1000000000]"},
      {"--steps", "1e3", "an integer in [1, 1000000000]"},
      {"--tolerance", "-1", "a finite number >= 0"},
      {"--tolerance", "nan", "a finite number >= 0"},
      {"--tolerance", "inf", "a finite number >= 0"},
      {"--stabilisation", "hard", "soft|baumgarte|split_impulse"},
      {"--slop", "-1", "a finite number >= 0"},
      {"--correction", "0", "a number in (0, 1]"},
      {"--correction", "1.5", "a number in (0, 1]"},
      {"--joint-solver", "exact", "auto|iterative|direct"},
      {"--joint-hertz", "0", "a finite number > 0"},
      {"--joint-hertz", "-1", "a finite number > 0"},
      {"--joint-hertz", "inf", "a finite number > 0"},
      {"--joint-hertz", "nan", "a finite number > 0"},
      {"--dt", "0", "a number in [1e-12, 1]"},
      {"--dt", "1.5", "a number in [1e-12, 1]"},
      {"--dt", "nan", "a number in [1e-12, 1]"},
      {"--dt", "0.1s", "a number in [1e-12, 1]"},
      {"--substeps", "0", "an integer in [1, 1024]"},
      {"--iterations", "1025", "an integer in [1, 1024]"},
      {"--relax-iterations", "-1", "an integer in [0, 1024]"},
      {"--friction", "0.5", "cone|pyramid"},
      {"--simd", "mmx", "auto|portable|sse4|avx2|avx512"},
      {"--format", "xml", "text|json"},
      {"--seed", "-1", "an integer in [0, 2^64)"},
      {"--out", "", "a file name"},
      {"--final-state", "", "a file name"},
  };
  for (const auto& refused : cases) {
    SCOPED_TRACE(std::string(refused.option) + " " + refused.value);
    expect_refused(run_atoll({"run", "stack", refused.option, refused.value}), 2, {refused.option, refused.expected});
  }
}

TEST(CommandUsage, RefusesBadScenes) {
  const ScratchDirectory scratch;
  const std::string truncated = scratch.write("truncated.json", "{\"format\": \"atoll-scene\",\n\"version\"");
  const std::string heavy = scratch.write("heavy.json", R"({"format": "atoll-scene", "version": 1,
    "bodies": [{"shape": {"type": "sphere", "radius": 1}, "mass": -1}]})");
  const std::string light = scratch.write("light.json", R"({"format": "atoll-scene", "version": 1,
    "bodies": [{"name": "dust", "shape": {"type": "sphere", "radius": 1}, "mass": 1e-320}]})");
  expect_refused(run_atoll({"run", "missing.json"}), 3, {"missing.json", "No such file"});
  expect_refused(run_atoll({"run", scratch.path("")}), 3, {"found a directory"});
  expect_refused(run_atoll({"run", truncated}), 3, {truncated + ":2:10: found end of input", "expected"});
  expect_refused(run_atoll({"run", heavy}), 3, {heavy + ":2: /bodies/0/mass: found -1, expected a number > 0"});
  expect_refused(run_atoll({"run", light}), 3, {"light: body 0 \"dust\"", "mass"});
  expect_refused(run_atoll({"run", "stak"}), 3, {"unknown scene \"stak\"", "did you mean \"stack\"?"});
  expect_refused(run_atoll({"run", "stack:hight=3"}), 3, {"unknown parameter \"hight\"", "did you mean \"height\"?"});
  expect_refused(run_atoll({"run", "stack:height=0"}), 3,
                 {"height: found \"0\", too small", "an integer in [1, 10000]"});
  expect_refused(run_atoll({"run", "stack:height=10001"}), 3,
                 {"found \"10001\", too large", "an integer in [1, 10000]"});
  EXPECT_EQ(run_atoll({"run", "stack:height=1e1", "--steps", "1"}).status, 0);
}

}  // namespace
}  // namespace atl::test
