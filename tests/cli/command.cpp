#include "cli/command.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace atl::test {

CommandResult run_atoll(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {ATOLL_COMMAND_PATH};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return run_program(std::move(words));
}

CommandResult run_program(std::vector<std::string> words) { return RunningProgram(std::move(words)).finish(); }

RunningProgram start_atoll(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {ATOLL_COMMAND_PATH};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return RunningProgram(std::move(words));
}

RunningProgram::RunningProgram(std::vector<std::string> words) {
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, scratch_.path("out").c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, scratch_.path("err").c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) sigaddset(&defaults, signal);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF);
  const int failed = posix_spawn(&child_, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error("cannot run " + words.front());
}

RunningProgram::~RunningProgram() {
  if (child_ == 0) return;
  send(SIGKILL);
  finish();
}

void RunningProgram::send(int signal) const { kill(child_, signal); }

bool RunningProgram::catches(int signal) const {
  const std::string caught = value_of("SigCgt:");
  return !caught.empty() && (std::stoull(caught, nullptr, 16) >> (signal - 1) & 1) != 0;
}

bool RunningProgram::has_ended() const { return value_of("State:").starts_with("\tZ"); }

std::string RunningProgram::value_of(const std::string& name) const {
  std::istringstream status(read_text("/proc/" + std::to_string(child_) + "/status"));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name)) return line.substr(name.size());
  }
  return "";
}

std::string RunningProgram::err() const { return read_text(scratch_.path("err")); }

CommandResult RunningProgram::finish() {
  int status = 0;
  waitpid(child_, &status, 0);
  child_ = 0;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(scratch_.path("out")), err(),
          WIFSIGNALED(status) ? WTERMSIG(status) : 0};
}

void wait_until(const std::function<bool()>& holds) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + std::chrono::minutes(10);
  while (!holds()) {
    ASSERT_LT(Clock::now(), end) << "waited for too long";
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

ScratchDirectory::ScratchDirectory() {
  std::string name = (std::filesystem::temp_directory_path() / "atoll_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make a directory like " + name);
  path_ = name;
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string ScratchDirectory::write(const std::string& name, const std::string& content) const {
  std::ofstream(path(name), std::ios::binary) << content;
  return path(name);
}

std::vector<std::string> ScratchDirectory::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::uintmax_t size_of(const std::string& path) {
  std::error_code none;
  const std::uintmax_t size = std::filesystem::file_size(path, none);
  return none ? 0 : size;
}

std::string read_text(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void expect_refused(const CommandResult& result, int status, const std::vector<std::string>& words) {
  EXPECT_EQ(result.status, status) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(lines_of(result.err).size(), 1u) << result.err;
  for (const std::string& word : words) {
    EXPECT_NE(result.err.find(word), std::string::npos) << "'" << result.err << "' does not hold '" << word << "'";
  }
}

}  // namespace atl::test
