// A short soak: that it runs, checks what it says and leaves behind what it says.

#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>

#include "cli/command.h"
#include "support/long_tests.h"

namespace atl::test {
namespace {

std::string line_of(const std::string& text, const std::string& beginning) {
  for (const std::string& line : lines_of(text)) {
    if (line.starts_with(beginning)) return line;
  }
  return "";
}

TEST(CommandSoak, AShortOneChecksAllAndTellsWhatItLost) {
  const ScratchDirectory scratch;
  const std::string folder = scratch.path("recordings");
  // Long enough for two recordings, and for a world that was empty to be restored.
  const auto soak_on = [&](const char* threads) {
    return run_atoll({"soak", "--steps", "1010", "--threads", threads, "--recordings", folder});
  };
  const CommandResult result = soak_on("2");
  EXPECT_EQ(result.status, 0) << result.err << result.out;
  EXPECT_EQ(result.err, "");
  EXPECT_NE(line_of(result.out, "soak ").find("2 threads"), std::string::npos) << result.out;
  EXPECT_TRUE(line_of(result.out, "steps ").starts_with("steps     1010;")) << result.out;
  EXPECT_NE(line_of(result.out, "checked").find("2 recordings"), std::string::npos) << result.out;
  // Losing bodies is a matter of physics, and reported. Recordings stay only if they show a loss.
  const bool lost = line_of(result.out, "lost") != "lost      0 bodies in quarantine, 0 through the ground";
  EXPECT_EQ(std::filesystem::is_empty(folder), !lost);
  EXPECT_EQ(result.out.find(".recording, step ") != std::string::npos, lost) << result.out;

  // Nothing of it is a matter of time or of threads; each soak compares hashes with a run on one thread, too.
  if (!long_tests()) return;
  const CommandResult other = soak_on("1");
  for (const char* line : {"came", "checked", "fastest", "lost"}) {
    EXPECT_NE(line_of(result.out, line), "");
    EXPECT_EQ(line_of(result.out, line), line_of(other.out, line));
  }
}

TEST(CommandSoak, EndsInOrder) {
  const ScratchDirectory scratch;
  RunningProgram soak = start_atoll({"soak", "--hours", "1", "--recordings", scratch.path("recordings")});
  wait_until([&] { return soak.catches(SIGINT); });
  soak.send(SIGINT);
  const CommandResult result = soak.finish();
  EXPECT_EQ(result.status, 130);
  EXPECT_NE(result.err.find("soak: interrupted by SIGINT after step"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("in quarantine"), std::string::npos) << result.out;
  if (std::filesystem::exists(scratch.path("recordings"))) {
    EXPECT_TRUE(std::filesystem::is_empty(scratch.path("recordings")));
  }
}

TEST(CommandSoak, RefusesWhatItCantDo) {
  expect_refused(run_atoll({"soak"}), 2, {"found no length", "--hours, --minutes or --steps"});
  expect_refused(run_atoll({"soak", "--hours", "0"}), 2, {"--hours", "a finite number > 0"});
  expect_refused(run_atoll({"soak", "--steps", "1", "--recordings", "/proc/none"}), 2, {"--recordings", "/proc/none"});
}

}  // namespace
}  // namespace atl::test
