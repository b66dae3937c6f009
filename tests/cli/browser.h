#pragma once
/// Loads a page in a headless Chromium, where there is one. It draws in software.

#include <optional>
#include <string>

namespace atl::test {

struct LoadedPage {
  int status = -1;
  std::string document;  ///< the elements as the scripts left them, as HTML
  std::string console;   ///< lines that scripts or the browser wrote to the page's console
};

/// The program, or nothing where none is installed or long tests weren't asked for.
std::optional<std::string> find_browser();
inline constexpr const char* without_browser = "no Chromium, or no long tests: the page is not looked at";

/// `place` is what follows the # of its address. Scripts have so many seconds, which pass as fast as they can.
LoadedPage load_page(const std::string& browser, const std::string& file, int width, const std::string& place = "",
                     int seconds = 0);

}  // namespace atl::test
