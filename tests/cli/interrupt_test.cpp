// Signals to commands that are under way.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cli/command.h"

namespace atl::test {
namespace {

using Json = nlohmann::ordered_json;
using Files = std::vector<std::string>;

void wait_for_handlers(const RunningProgram& program) {
  wait_until([&] { return program.catches(SIGINT) && program.catches(SIGTERM) && program.catches(SIGHUP); });
}

void expect_one_line(const std::string& err, const std::vector<std::string>& words) {
  EXPECT_EQ(lines_of(err).size(), 1u) << err;
  for (const std::string& word : words) EXPECT_NE(err.find(word), std::string::npos) << err;
}

TEST(CommandInterrupt, ARunEndsInOrder) {
  const struct {
    int signal;
    int status;
    const char* name;
  } cases[] = {{SIGINT, 130, "SIGINT"}, {SIGTERM, 143, "SIGTERM"}, {SIGHUP, 129, "SIGHUP"}};
  for (const auto& [signal, status, name] : cases) {
    SCOPED_TRACE(name);
    const ScratchDirectory scratch;
    const std::string rec = scratch.path("rec");
    ASSERT_EQ(run_atoll({"run", "stack", "--steps", "100", "--record", rec}).status, 0);
    const std::uintmax_t size_of_100_steps = size_of(rec);
    std::filesystem::remove(rec);
    RunningProgram run =
        start_atoll({"run", "stack", "--steps", "1000000000", "--threads", "1", "--format", "json", "--record", rec,
                     "--out", scratch.path("out"), "--final-state", scratch.path("state")});
    wait_until([&] { return size_of(rec + ".partial") > size_of_100_steps; });
    run.send(signal);
    const CommandResult result = run.finish();
    EXPECT_EQ(result.status, status);
    const Json json = Json::parse(result.out);
    const int steps = json["steps"];
    EXPECT_GE(steps, 100);
    EXPECT_EQ(json["interrupted"]["by"], name);
    EXPECT_EQ(json["interrupted"]["steps_asked"], 1000000000);
    EXPECT_TRUE(json["errors"].contains("drift_max"));
    expect_one_line(result.err, {"stack", name, "after step " + std::to_string(steps) + " of 1000000000"});
    EXPECT_EQ(scratch.files(), (Files{"out", "rec", "state"}));
    EXPECT_EQ(read_text(scratch.path("out")), result.out);
    EXPECT_EQ(lines_of(read_text(scratch.path("state"))).size(), 12u);
    const Json replayed = Json::parse(run_atoll({"replay", rec, "--format", "json"}).out);
    EXPECT_EQ(replayed["complete"], true);
    EXPECT_EQ(replayed["same"], true);
    EXPECT_EQ(replayed["steps"], steps);
    EXPECT_EQ(replayed["hash"], json["hash"]);
  }
}

TEST(CommandInterrupt, ARunSaysSoInWords) {
  RunningProgram run = start_atoll({"run", "stack", "--steps", "1000000000", "--threads", "1"});
  wait_for_handlers(run);
  run.send(SIGINT);
  const CommandResult result = run.finish();
  EXPECT_EQ(result.status, 130);
  for (const char* words : {"of 1000000000 steps of", "by SIGINT", "penetration_max", "hash"}) {
    EXPECT_NE(result.out.find(words), std::string::npos) << result.out;
  }
}

TEST(CommandInterrupt, TheSecondSignalEndsARunAtOnce) {
  const ScratchDirectory scratch;
  // The first signal ends the steps, and then a file that nobody reads keeps the run from its end.
  const std::string unread = scratch.path("unread");
  ASSERT_EQ(mkfifo(unread.c_str(), 0600), 0);
  const Files words = {"run", "stack", "--threads", "1", "--record", scratch.path("rec"), "--steps"};
  const auto with = [&](const Files& more) {
    Files all = words;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  ASSERT_EQ(run_atoll(with({"100"})).status, 0);
  const std::uintmax_t size_of_100_steps = size_of(scratch.path("rec"));
  std::filesystem::remove(scratch.path("rec"));
  RunningProgram run = start_atoll(with({"1000000000", "--final-state", unread}));
  wait_until([&] { return size_of(scratch.path("rec.partial")) > size_of_100_steps; });
  run.send(SIGINT);
  wait_until([&] { return !run.catches(SIGINT); });
  run.send(SIGINT);
  const CommandResult result = run.finish();
  EXPECT_EQ(result.signal, SIGINT) << "which shells tell as status 130";
  EXPECT_EQ(scratch.files(), (Files{"rec.partial", "unread"}));
  const Json replayed = Json::parse(run_atoll({"replay", scratch.path("rec.partial"), "--format", "json"}).out);
  EXPECT_EQ(replayed["complete"], false);
  EXPECT_EQ(replayed["same"], true);
  EXPECT_GE(replayed["steps"], 100);
}

TEST(CommandInterrupt, AnIgnoredSignalStaysIgnored) {
  RunningProgram run(
      {"/bin/sh", "-c", "trap '' HUP; exec \"$0\" run stack --steps 1000000000 --threads 1", ATOLL_COMMAND_PATH});
  wait_until([&] { return run.catches(SIGTERM) && run.catches(SIGINT); });
  EXPECT_FALSE(run.catches(SIGHUP));
  run.send(SIGHUP);
  run.send(SIGTERM);
  const CommandResult result = run.finish();
  EXPECT_EQ(result.status, 143);
  expect_one_line(result.err, {"SIGTERM"});
}

// Replays a recording of so many steps and interrupts it. False where it came to its end before the signal did.
bool interrupts_a_replay_of(int steps) {
  const ScratchDirectory scratch;
  EXPECT_EQ(run_atoll({"run", "pile:bodies=300", "--steps", std::to_string(steps), "--record", scratch.path("rec")}).status,
            0);
  RunningProgram replay = start_atoll({"replay", scratch.path("rec"), "--threads", "1", "--format", "json"});
  wait_until([&] { return replay.catches(SIGINT) || replay.has_ended(); });
  replay.send(SIGINT);
  const CommandResult result = replay.finish();
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["same"], true);
  EXPECT_EQ(json["recorded_steps"], steps);
  EXPECT_EQ(scratch.files(), Files{"rec"});
  EXPECT_GE(json["steps"], 1);
  if (json["steps"] == steps) {
    EXPECT_EQ(result.status, 0);
    return false;
  }
  EXPECT_EQ(result.status, 130);
  EXPECT_LT(json["steps"], steps);
  expect_one_line(result.err, {"SIGINT after step " + json["steps"].dump() + " of " + std::to_string(steps)});
  return true;
}

TEST(CommandInterrupt, AReplayTellsWhatItHas) {
  int steps = 1000;
  while (!interrupts_a_replay_of(steps)) {
    ASSERT_LT(steps, 1'000'000) << "no signal ends a replay";
    steps *= 4;
  }
}

TEST(CommandInterrupt, AnExplanationIsOfTheStepsSoFar) {
  RunningProgram explain =
      start_atoll({"explain", "stack", "--steps", "1000000000", "--threads", "1", "--format", "json"});
  wait_for_handlers(explain);
  explain.send(SIGTERM);
  const CommandResult result = explain.finish();
  EXPECT_EQ(result.status, 143);
  const Json json = Json::parse(result.out);
  EXPECT_GE(json["steps"], 1);
  expect_one_line(result.err, {"SIGTERM after step " + json["steps"].dump() + " of 1000000000"});
}

TEST(CommandInterrupt, VerifyEndsInOrder) {
  RunningProgram scene = start_atoll({"verify", "stack", "--steps", "1000000000"});
  wait_for_handlers(scene);
  scene.send(SIGINT);
  expect_refused(scene.finish(), 130, {"SIGINT in the first run"});

  RunningProgram suite = start_atoll({"verify", "--stability", "--format", "json"});
  wait_for_handlers(suite);
  suite.send(SIGINT);
  const CommandResult result = suite.finish();
  EXPECT_EQ(result.status, 130);
  // It ends after the case that the signal found it in.
  const std::size_t cases = Json::parse(result.out)["cases"].size();
  EXPECT_GE(cases, 1u);
  expect_one_line(result.err, {"--stability", "after " + std::to_string(cases) + " of "});
}

TEST(CommandInterrupt, ASweepWritesWhatHasBeenRun) {
  const ScratchDirectory scratch;
  // Times of every setting are taken in rounds, of another engine last. In the second round it never ends.
  const std::string first = scratch.path("first"), second = scratch.path("second");
  const std::string driver = scratch.write("driver", R"(#!/bin/sh
case "$*" in
  --describe*) echo '{"engine": "Mock", "version": "1", "settings": [{"label": "default", "options": []}]}' ;;
  *--errors*) echo '{"errors": {"penetration_mean": 1}}' ;;
  *) if [ -e ")" + first + R"(" ]; then echo >")" + second + R"("; exec sleep 100000; fi
     echo >")" + first + R"("
     echo '{"cpu_s_per_simulated_s": 1, "ms_per_step": {"mean": 1}}' ;;
esac
)");
  std::filesystem::permissions(driver, std::filesystem::perms::owner_all);
  RunningProgram sweep =
      start_atoll({"sweep", "stack:height=2", "stack:height=3", "--substeps", "1,2", "--iterations", "1", "--steps",
                   "3", "--repeats", "2", "--time", "0.001", "--peer", driver, "--peer-limit", "86400", "--out",
                   scratch.path("sweep")});
  wait_until([&] { return size_of(second) > 0; });
  sweep.send(SIGINT);
  const CommandResult result = sweep.finish();
  EXPECT_EQ(result.status, 130);
  EXPECT_NE(result.err.find("sweep: interrupted by SIGINT with 1 of 2 scenes"), std::string::npos) << result.err;
  const Json json = Json::parse(read_text(scratch.path("sweep/results.json")));
  EXPECT_EQ(json["interrupted"], true);
  ASSERT_EQ(json["scenes"].size(), 1u);
  EXPECT_GE(json["scenes"][0]["runs"].size(), 1u);
  EXPECT_NE(result.out.find("index.html"), std::string::npos);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(scratch.path("sweep"))) ++files;
  EXPECT_EQ(files, 3u);
}

TEST(CommandInterrupt, ASweepOfNothingWritesNothing) {
  const ScratchDirectory scratch;
  RunningProgram sweep = start_atoll({"sweep", "stack", "--steps", "100000000", "--out", scratch.path("sweep")});
  wait_for_handlers(sweep);
  sweep.send(SIGINT);
  expect_refused(sweep.finish(), 130, {"SIGINT with 0 of 1 scene", "nothing was written"});
  EXPECT_TRUE(std::filesystem::is_empty(scratch.path("sweep")));
}

TEST(CommandInterrupt, ASweepTakesOtherEnginesWithIt) {
  const ScratchDirectory scratch;
  const std::string driver =
      scratch.write("driver", "#!/bin/sh\necho $$ > " + scratch.path("pid") + "\nexec sleep 100000\n");
  std::filesystem::permissions(driver, std::filesystem::perms::owner_all);
  RunningProgram sweep =
      start_atoll({"sweep", "stack", "--peer", driver, "--peer-limit", "86400", "--out", scratch.path("sweep")});
  wait_until([&] { return size_of(scratch.path("pid")) > 0; });
  sweep.send(SIGTERM);
  expect_refused(sweep.finish(), 143, {"SIGTERM"});
  EXPECT_NE(kill(std::stoi(read_text(scratch.path("pid"))), 0), 0) << "the driver still runs";
}

}  // namespace
}  // namespace atl::test
