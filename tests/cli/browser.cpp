#include "cli/browser.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "cli/command.h"
#include "support/long_tests.h"

namespace atl::test {

std::optional<std::string> find_browser() {
  if (!long_tests()) return std::nullopt;
  const char* path = std::getenv("PATH");
  for (const char* name : {"chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"}) {
    std::istringstream directories(path != nullptr ? path : "");
    for (std::string directory; std::getline(directories, directory, ':');) {
      const std::string program = directory + "/" + name;
      if (::access(program.c_str(), X_OK) == 0) return program;
    }
  }
  return std::nullopt;
}

LoadedPage load_page(const std::string& browser, const std::string& file, int width, const std::string& place,
                     int seconds) {
  const ScratchDirectory profile;
  std::vector<std::string> words = {browser,
                                    "--headless",
                                    "--no-sandbox",
                                    "--use-angle=swiftshader",
                                    "--enable-unsafe-swiftshader",
                                    "--ignore-gpu-blocklist",
                                    "--disable-quic",
                                    "--no-first-run",
                                    "--disable-background-networking",
                                    "--disable-component-update",
                                    "--disable-sync",
                                    "--disable-dev-shm-usage",
                                    "--user-data-dir=" + profile.path("profile"),
                                    "--enable-logging=stderr",
                                    "--window-size=" + std::to_string(width) + ",900"};
  if (seconds > 0) words.push_back("--virtual-time-budget=" + std::to_string(1000 * seconds));
  words.push_back("--dump-dom");
  words.push_back("file://" + std::filesystem::absolute(file).string() + (place.empty() ? "" : "#" + place));
  const CommandResult result = run_program(words);
  std::string console;
  for (const std::string& line : lines_of(result.err)) {
    if (line.find(":CONSOLE") != std::string::npos) console += line + "\n";
  }
  return {result.status, result.out, console};
}

}  // namespace atl::test
