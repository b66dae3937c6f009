// `atoll ensemble` and `atoll import` hand over to Python. A script stands in for the interpreter.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>

#include "cli/command.h"

namespace atl::test {
namespace {

namespace fs = std::filesystem;

// Stands in for Python: asked for the package by -c, it has it unless WITHOUT says otherwise.
constexpr const char* tells_words =
    "#!/bin/sh\n"
    "if [ \"$1\" = -c ]; then exit \"${WITHOUT:-0}\"; fi\n"
    "echo \"path $PYTHONPATH\"\n"
    "printf '<%s>\\n' \"$@\"\n"
    "exit 42\n";

std::string script(const ScratchDirectory& scratch, const std::string& name, const std::string& content) {
  const std::string path = scratch.write(name, content);
  fs::permissions(path, fs::perms::owner_all);
  return path;
}

// Runs `atoll ensemble ...` like a shell, with these variables.
std::vector<std::string> ensemble(const std::vector<std::string>& environment,
                                  const std::vector<std::string>& arguments,
                                  const std::string& command = ATOLL_COMMAND_PATH) {
  std::vector<std::string> words = {"/usr/bin/env", "-u", "PYTHONPATH"};
  words.insert(words.end(), environment.begin(), environment.end());
  words.push_back(command);
  words.push_back("ensemble");
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

void expect_words(const CommandResult& result, const std::string& words) {
  EXPECT_EQ(result.status, 42);
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out.substr(result.out.find('\n') + 1), words);
}

TEST(CommandEnsemble, HandsAllWordsOver) {
  const ScratchDirectory scratch;
  const std::string python = "ATOLL_PYTHON=" + script(scratch, "py", tells_words);
  expect_words(
      run_program(ensemble({python}, {"a plan.json", "--out", "", "--engine=ray", "--", "-x", "--workers", "2"})),
      "<-m>\n<atoll>\n<ensemble>\n<a plan.json>\n<--out>\n<>\n<--engine=ray>\n<-->\n<-x>\n<--workers>\n<2>\n");
  expect_words(run_program(ensemble({python}, {"--help"})), "<-m>\n<atoll>\n<ensemble>\n<--help>\n");
  expect_words(run_program(ensemble({python}, {"--version"})), "<-m>\n<atoll>\n<ensemble>\n<--version>\n");
  expect_words(run_program(ensemble({python}, {})), "<-m>\n<atoll>\n<ensemble>\n");
}

TEST(CommandEnsemble, LooksForPythonOnThePath) {
  const ScratchDirectory scratch;
  script(scratch, "python3", tells_words);
  for (const char* unset : {"ATOLL_PYTHON=", "-uATOLL_PYTHON"}) {
    expect_words(run_program(ensemble({unset, "PATH=" + scratch.path("") + ":/usr/bin:/bin"}, {"plan"})),
                 "<-m>\n<atoll>\n<ensemble>\n<plan>\n");
  }
}

TEST(CommandEnsemble, TakesThePackageBesideIt) {
  const ScratchDirectory scratch;
  const std::string python = "ATOLL_PYTHON=" + script(scratch, "py", tells_words);
  fs::create_directories(scratch.path("python/atoll"));
  fs::create_directories(scratch.path("bin"));
  fs::copy_file(ATOLL_COMMAND_PATH, scratch.path("bin/atoll"));
  const auto path = [&](const char* before) {
    return lines_of(run_program(ensemble({python, before}, {}, scratch.path("bin/atoll"))).out).front();
  };
  EXPECT_EQ(path("PYTHONPATH=/other"), "path /other");
  scratch.write("python/atoll/__init__.py", "");
  const std::string beside = fs::canonical(scratch.path("python")).string();
  EXPECT_EQ(path("PYTHONPATH=/other"), "path " + beside + ":/other");
  EXPECT_EQ(path("PYTHONPATH="), "path " + beside);
}

TEST(CommandEnsemble, SignalsArePythons) {
  const ScratchDirectory scratch;
  const std::string python = script(scratch, "py",
                                    "#!/bin/sh\n"
                                    "if [ \"$1\" = -c ]; then exit; fi\n"
                                    "trap 'echo stopped; exit 143' TERM\n"
                                    "echo ready >&2\n"
                                    "while :; do sleep 0.01; done\n");
  RunningProgram run(ensemble({"ATOLL_PYTHON=" + python}, {"plan"}));
  wait_until([&] { return run.err() == "ready\n"; });
  run.send(SIGTERM);
  const CommandResult result = run.finish();
  EXPECT_EQ(result.status, 143);
  EXPECT_EQ(result.out, "stopped\n");
}

TEST(CommandEnsemble, RefusesToRunWithoutPythonOrPackage) {
  const ScratchDirectory scratch;
  expect_refused(
      run_program(ensemble({"ATOLL_PYTHON=" + scratch.path("none")}, {"--help"})), 2,
      {"ensemble: cannot run \"" + scratch.path("none") + "\": No such file", "Python 3.11", "ATOLL_PYTHON"});
  expect_refused(run_program(ensemble({"-uATOLL_PYTHON", "PATH=" + scratch.path("")}, {"plan"})), 2,
                 {"cannot run \"python3\": No such file"});
  const std::string text = scratch.write("text", "");
  expect_refused(run_program(ensemble({"ATOLL_PYTHON=" + text}, {"plan"})), 2, {"cannot run", "Permission denied"});
  const std::string python = script(scratch, "py", tells_words);
  expect_refused(run_program(ensemble({"ATOLL_PYTHON=" + python, "WITHOUT=64"}, {"plan"})), 2,
                 {python + " has no package \"atoll\"", "pip install \"atoll[ensemble]\"", "ATOLL_PYTHON"});
  std::vector<std::string> words = ensemble({"ATOLL_PYTHON=" + python, "WITHOUT=64"}, {"robot.xml"});
  *std::find(words.begin(), words.end(), "ensemble") = "import";
  expect_refused(run_program(words), 2, {"import: " + python + " has no package", "pip install \"atoll[robots]\""});
}

}  // namespace
}  // namespace atl::test
