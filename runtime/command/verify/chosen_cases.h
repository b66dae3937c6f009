#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "../failure.h"
#include "../interrupt.h"
#include "scene/src/words.h"

namespace atl::command {

/// The cases of a suite that have the names, in that order; all cases, if there are no names. `suite` is the option
/// that runs it. Throws Failure on a name that no case has.
template <typename Case>
std::vector<Case> chosen_cases(const std::vector<Case>& all, const std::vector<std::string>& names,
                               std::string_view suite) {
  if (names.empty()) return all;
  std::vector<Case> chosen;
  for (const std::string& name : names) {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Case& c) { return c.name == name; });
    if (found == all.end()) {
      std::vector<std::string_view> known;
      for (const Case& c : all) known.push_back(c.name);
      throw Failure(Status::Usage, "--case: found " + scene::quote(name) +
                                       ", expected a name from the table of atoll verify " + std::string(suite) +
                                       scene::suggestion(name, known));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

/// The failure of a suite that a signal ended ahead of its last case.
inline Failure interrupted_suite(const std::string& suite, std::size_t done, std::size_t asked) {
  return interruption("verify " + suite, "after " + std::to_string(done) + " of " + std::to_string(asked) + " cases");
}

}  // namespace atl::command
