#include "python_command.h"

#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "failure.h"

namespace atl::command {
namespace {

constexpr int without_package = 64;  // an exit status that Python has no meaning for

// All that a broken package raises is left to the run itself, whose traceback tells more.
constexpr const char* import_package =
    "try: import atoll\n"
    "except ModuleNotFoundError as error: exit(64 if error.name in ('atoll', 'atoll._core', 'numpy') else 0)\n"
    "except Exception: pass";

std::string interpreter() {
  const char* named = ::getenv("ATOLL_PYTHON");
  return named != nullptr && *named != '\0' ? named : "python3";
}

Failure no_python(const std::string& command, const std::string& python, int error) {
  return {Status::Usage, command + ": cannot run \"" + python + "\": " + std::generic_category().message(error) +
                             " (it takes Python 3.11 or newer; ATOLL_PYTHON may name it)"};
}

void take_package_beside_executable() {
  std::error_code error;
  const std::filesystem::path executable = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::filesystem::path beside = executable.parent_path().parent_path() / "python";
  if (error || !std::filesystem::exists(beside / "atoll" / "__init__.py", error)) return;
  const char* path = ::getenv("PYTHONPATH");
  ::setenv("PYTHONPATH", (beside.string() + (path != nullptr && *path != '\0' ? ":" + std::string(path) : "")).c_str(),
           1);
}

void require_package(const std::string& command, const std::string& python) {
  std::array<std::string, 3> words = {python, "-c", import_package};
  std::array<char*, 4> argv = {words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, python.c_str(), nullptr, nullptr, argv.data(), environ);
  if (error != 0) throw no_python(command, python, error);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  if (WIFEXITED(status) && WEXITSTATUS(status) == without_package) {
    const std::string extra = command == "import" ? "robots" : "ensemble";
    throw Failure(Status::Usage, command + ": " + python +
                                     " has no package \"atoll\" that was built for it (pip install \"atoll[" + extra +
                                     "]\", or let ATOLL_PYTHON name a Python that has it)");
  }
}

}  // namespace

bool is_python_command(int argc, char** argv) {
  return argc > 1 && (std::string_view(argv[1]) == "ensemble" || std::string_view(argv[1]) == "import");
}

void run_python_command(char** argv) {
  const std::string command = argv[1], python = interpreter();
  take_package_beside_executable();
  require_package(command, python);
  std::vector<std::string> words = {python, "-m", "atoll"};
  std::vector<char*> all;
  for (std::string& word : words) all.push_back(word.data());
  for (char** word = argv + 1; *word != nullptr; ++word) all.push_back(*word);
  all.push_back(nullptr);
  ::execvp(python.c_str(), all.data());
  throw no_python(command, python, errno);
}

}  // namespace atl::command
