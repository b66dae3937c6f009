#pragma once
/// Loads a page in a headless Chromium, where there is one.

#include <optional>
#include <string>

namespace atl::test {

struct LoadedPage {
  int status = -1;
  std::string document;  ///< the elements as the scripts left them, as HTML
  std::string console;   ///< lines that scripts or the browser wrote to the page's console
};

/// The program, or nothing where none is installed.
std::optional<std::string> find_browser();

LoadedPage load_page(const std::string& browser, const std::string& file, int width);

}  // namespace atl::test
