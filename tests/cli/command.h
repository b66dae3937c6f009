#pragma once
/// Runs the atoll command as a user does: another process, its exit status and what it printed.

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "support/words.h"

namespace atl::test {

struct CommandResult {
  int status = -1;  ///< exit status; -1 where a signal ended it
  std::string out;
  std::string err;
  int signal = 0;  ///< that ended it; 0 where it exited
};

CommandResult run_atoll(const std::vector<std::string>& arguments);
/// The first word is the program's path.
CommandResult run_program(std::vector<std::string> words);

/// A directory of the running test's own, removed with everything in it.
class ScratchDirectory {
 public:
  ScratchDirectory();
  ~ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;

  std::string path(const std::string& name) const { return path_ + "/" + name; }
  std::string write(const std::string& name, const std::string& content) const;
  /// Names of all files in it, sorted.
  std::vector<std::string> files() const;

 private:
  std::string path_;
};

/// A program that runs while the test goes on, without a terminal and with no signal ignored. The first word is its
/// path.
class RunningProgram {
 public:
  explicit RunningProgram(std::vector<std::string> words);
  ~RunningProgram();  ///< kills it if it still runs
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  void send(int signal) const;
  /// True once it has a handler for the signal.
  bool catches(int signal) const;
  bool has_ended() const;
  std::string err() const;  ///< so far
  CommandResult finish();   ///< waits for its end

 private:
  /// A line of the status that /proc has of it; "" where there is none of that name.
  std::string value_of(const std::string& name) const;

  ScratchDirectory scratch_;
  pid_t child_ = 0;
};

RunningProgram start_atoll(const std::vector<std::string>& arguments);
/// Waits for something that a program does; fails the test if it takes more than ten minutes.
void wait_until(const std::function<bool()>& holds);

std::string read_text(const std::string& path);
/// Bytes; 0 of no file.
std::uintmax_t size_of(const std::string& path);
inline std::vector<std::string> lines_of(const std::string& text) { return words_of(text, '\n'); }

/// Expects this status, nothing on stdout and one line on stderr that holds all the words.
void expect_refused(const CommandResult& result, int status, const std::vector<std::string>& words);

}  // namespace atl::test
