#pragma once

#include <string>
#include <vector>

#include "../run_options.h"

namespace atl::command {

/// Options of `atoll verify`.
struct VerifyOptions {
  bool stability = false;
  bool physics = false;
  bool refine = false;             ///< runs cases of physics in finer steps, too
  std::vector<std::string> cases;  ///< names; all where there is none

  SceneOptions scene;  ///< to check for determinism, unless its text is ""
  std::vector<int> threads = {1, 2, 4};
  std::vector<std::string> simds = {"all"};  ///< names, or "all" for those of this machine
  bool restore = false;                      ///< also runs that are saved and restored on the way

  Format format = Format::Text;
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_verify_options(CLI::App& command, VerifyOptions& options);

}  // namespace atl::command
