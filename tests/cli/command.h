#pragma once
/// Runs the atoll command as a user does: another process, its exit status and what it printed.

#include <string>
#include <vector>

namespace atl::test {

struct CommandResult {
  int status = -1;  ///< exit status; -1 where a signal ended it
  std::string out;
  std::string err;
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

std::string read_text(const std::string& path);
std::vector<std::string> lines_of(const std::string& text);

/// Expects this status, nothing on stdout and one line on stderr that holds all the words.
void expect_refused(const CommandResult& result, int status, const std::vector<std::string>& words);

}  // namespace atl::test
