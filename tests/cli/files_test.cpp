// Output that can't go where it should: full disks, closed pipes, folders that are read-only or vanish.

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "cli/command.h"

namespace atl::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

CommandResult shell(const std::string& script, const std::vector<std::string>& arguments = {}) {
  std::vector<std::string> words = {"/bin/bash", "-c", script, ATOLL_COMMAND_PATH};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return run_program(words);
}

// Words for the shell that make a pipe's writer wait until its reader has gone.
const std::string wait_for_its_end = "(trap '' PIPE; while echo; do :; done 2>/dev/null); ";

TEST(CommandFiles, AClosedPipeEndsItWithoutAWord) {
  for (const std::string command : {"scenes", "run stack --steps 1", "run stack --steps 1 --format json --profile",
                                    "explain stack --steps 1", "verify stack --steps 1", "--help", "run --help"}) {
    SCOPED_TRACE(command);
    const CommandResult result =
        shell("{ " + wait_for_its_end + "exec \"$0\" " + command + "; } | true; echo ${PIPESTATUS[0]}");
    EXPECT_EQ(result.out, "141\n") << "128 + SIGPIPE";
    EXPECT_EQ(result.err, "");
  }
}

TEST(CommandFiles, AClosedPipeCostsNoFile) {
  const ScratchDirectory scratch;
  const CommandResult result = shell(
      "{ " + wait_for_its_end +
          "exec \"$0\" run stack --steps 3 --record $1/rec --out $1/out --final-state $1/state; } | true; "
          "echo ${PIPESTATUS[0]}",
      {scratch.path("")});
  EXPECT_EQ(result.out, "141\n");
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"out", "rec", "state"}));
  EXPECT_EQ(Json::parse(read_text(scratch.path("out")))["steps"], 3);
}

TEST(CommandFiles, WhereSigpipeIsIgnoredAClosedPipeIsAnError) {
  const CommandResult result =
      shell("trap '' PIPE; { " + wait_for_its_end + "exec \"$0\" run stack --steps 1; } | true; echo ${PIPESTATUS[0]}");
  EXPECT_EQ(result.out, "2\n");
  EXPECT_EQ(lines_of(result.err).size(), 1u) << result.err;
  EXPECT_NE(result.err.find("Broken pipe"), std::string::npos) << result.err;
}

TEST(CommandFiles, ALostReaderOfMessagesChangesNothing) {
  const ScratchDirectory scratch;
  const CommandResult result = shell(
      "{ " + wait_for_its_end +
          "\"$0\" sweep stack:height=2 stack:height=3 --substeps 1 --iterations 1 --steps 2 --repeats 1 --time 1e-6 "
          "--out $1/sweep 2>&1 >$1/text; echo $? >$1/status; } | true",
      {scratch.path("")});
  EXPECT_EQ(read_text(scratch.path("status")), "0\n");
  EXPECT_GT(size_of(scratch.path("sweep/index.html")), 0u);
}

TEST(CommandFiles, AStreamThatIsClosedIsNotMistakenForAFile) {
  const ScratchDirectory scratch;
  const CommandResult result = shell("exec \"$0\" run stack --steps 3 --record $1/rec >&-", {scratch.path("")});
  EXPECT_EQ(result.status, 2);
  EXPECT_NE(result.err.find("standard output"), std::string::npos) << result.err;
  const Json replayed = Json::parse(run_atoll({"replay", scratch.path("rec"), "--format", "json"}).out);
  EXPECT_EQ(replayed["complete"], true);
  EXPECT_EQ(shell("exec \"$0\" run stack --steps 1 --record $1/rec 2>&- <&-", {scratch.path("")}).status, 0);
}

TEST(CommandFiles, AFullDeviceCostsNeitherResultsNorOtherFiles) {
  const ScratchDirectory scratch;
  for (const std::string full : {"--out", "--final-state"}) {
    SCOPED_TRACE(full);
    const std::string other = full == "--out" ? "--final-state" : "--out";
    const CommandResult result = run_atoll({"run", "stack", "--steps", "1", full, "/dev/full", other,
                                            scratch.path("other"), "--record", scratch.path("rec")});
    EXPECT_EQ(result.status, 2);
    EXPECT_EQ(lines_of(result.err).size(), 1u) << result.err;
    EXPECT_NE(result.err.find(full + ": cannot write /dev/full: No space left on device"), std::string::npos)
        << result.err;
    EXPECT_NE(result.out.find("hash"), std::string::npos);
    EXPECT_EQ(scratch.files(), (std::vector<std::string>{"other", "rec"}));
    EXPECT_EQ(run_atoll({"replay", scratch.path("rec")}).status, 0);
  }
}

// In a mount namespace of its own, for which one has to be root, or to be let.
class CommandFullDisk : public testing::Test {
 protected:
  void SetUp() override {
    if (shell("unshare -m --map-root-user true").status != 0) GTEST_SKIP() << "no mount namespaces here";
  }
  // $1 is a disk of 64 kB.
  CommandResult on_small_disk(const std::string& script) const {
    return shell(
        "unshare -m --map-root-user bash -c 'mount -t tmpfs -o size=64k none \"$1\" && " + script + "' \"$0\" $1",
        {scratch_.path("")});
  }

 private:
  ScratchDirectory scratch_;
};

TEST_F(CommandFullDisk, EndsARecordingInOneLineAndKeepsTheResults) {
  const CommandResult result =
      on_small_disk("\"$0\" run pile:bodies=200 --steps 60 --record $1/rec; echo status $?; ls -A $1");
  EXPECT_NE(result.out.find("\nstatus 2\n"), std::string::npos) << result.out << result.err;
  EXPECT_TRUE(result.out.ends_with("status 2\n")) << "what is left of it: " << result.out;
  EXPECT_NE(result.out.find("hash"), std::string::npos);
  EXPECT_EQ(lines_of(result.err).size(), 1u) << result.err;
  EXPECT_NE(result.err.find("No space left on device"), std::string::npos) << result.err;
}

TEST_F(CommandFullDisk, KeepsTheOldFileAndNoHalfOfTheNew) {
  const CommandResult result = on_small_disk(
      "echo old > $1/state && \"$0\" run pile:bodies=2000 --steps 1 --final-state $1/state; echo status $?; cat "
      "$1/state; "
      "ls -A $1");
  EXPECT_TRUE(result.out.ends_with("status 2\nold\nstate\n")) << result.out << result.err;
  EXPECT_EQ(lines_of(result.err).size(), 1u) << result.err;
}

TEST_F(CommandFullDisk, EndsASweepWithItsResultsInWords) {
  const CommandResult result = on_small_disk(
      "\"$0\" sweep stack:height=2 --steps 2 --repeats 1 --time 1e-6 --out $1/sweep; echo status $?; ls -A $1/sweep");
  EXPECT_NE(result.out.find("stack:height=2"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("status 2\n"), std::string::npos) << result.out << result.err;
  EXPECT_EQ(result.out.find(".tmp"), std::string::npos) << result.out;
  EXPECT_EQ(result.err.find("wrote"), std::string::npos);
}

TEST_F(CommandFullDisk, EndsASoak) {
  const CommandResult result = on_small_disk("\"$0\" soak --steps 600 --recordings $1; echo status $?; ls -A $1");
  EXPECT_TRUE(result.out.ends_with("status 2\n")) << result.out << result.err;
  EXPECT_NE(result.err.find("--recordings: "), std::string::npos) << result.err;
}

TEST(CommandFiles, AFolderThatVanishesCostsNoResults) {
  const ScratchDirectory scratch;
  fs::create_directory(scratch.path("folder"));
  RunningProgram run = start_atoll({"run", "stack", "--steps", "1000000000", "--threads", "1", "--record",
                                    scratch.path("folder/rec"), "--out", scratch.path("folder/out"), "--final-state",
                                    scratch.path("folder/state"), "--format", "json"});
  wait_until([&] { return size_of(scratch.path("folder/rec.partial")) > 20'000; });
  fs::remove_all(scratch.path("folder"));
  run.send(SIGINT);
  const CommandResult result = run.finish();
  EXPECT_EQ(result.status, 2);
  EXPECT_EQ(lines_of(result.err).size(), 1u) << result.err;
  for (const char* option : {"--record", "--out", "--final-state"}) {
    EXPECT_NE(result.err.find(option), std::string::npos) << result.err;
  }
  EXPECT_NE(result.err.find("No such file or directory"), std::string::npos) << result.err;
  EXPECT_GT(Json::parse(result.out)["steps"], 1);
  EXPECT_TRUE(scratch.files().empty());
}

TEST(CommandFiles, AFolderThatMayNotBeWrittenIsToldAhead) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write to all";
  const ScratchDirectory scratch;
  fs::create_directory(scratch.path("folder"));
  fs::permissions(scratch.path("folder"), fs::perms::owner_read | fs::perms::owner_exec);
  for (const char* option : {"--record", "--out", "--final-state"}) {
    expect_refused(run_atoll({"run", "stack", "--steps", "1000000000", option, scratch.path("folder/file")}), 2,
                   {option, "Permission denied"});
  }
  fs::permissions(scratch.path("folder"), fs::perms::owner_all);
}

TEST_F(CommandFullDisk, AReadOnlyDiskIsToldAhead) {
  const CommandResult result = on_small_disk(
      "mount -o remount,ro $1 && for o in --record --out --final-state; do \"$0\" run stack --steps 1000000000 $o "
      "$1/file; "
      "echo status $?; done; \"$0\" sweep stack --out $1/sweep; echo status $?; \"$0\" soak --steps 1 --recordings $1; "
      "echo status $?");
  EXPECT_EQ(result.out, "status 2\nstatus 2\nstatus 2\nstatus 2\nstatus 2\n") << result.err;
  EXPECT_EQ(lines_of(result.err).size(), 5u) << result.err;
}

TEST(CommandFiles, ALostBodyIsToldWithAFileThatCantBeWritten) {
  const ScratchDirectory scratch;
  const std::string scene = scratch.write("fast.json", R"({"format": "atoll-scene", "version": 1, "steps": 9,
    "bodies": [{"name": "rocket", "shape": {"type": "sphere", "radius": 1}, "velocity": [0, 0, 1e7]}]})");
  const CommandResult result = run_atoll({"run", scene, "--final-state", "/dev/full"});
  expect_refused(result, 4, {"rocket", "--final-state: cannot write /dev/full: No space left on device"});
}

}  // namespace
}  // namespace atl::test
