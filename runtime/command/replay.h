#pragma once

#include <optional>
#include <string>

#include "run_options.h"

namespace atl::command {

/// Options of `atoll replay`.
struct ReplayFileOptions {
  std::string path;
  int threads = 1;
  Simd simd = Simd::Auto;
  Format format = Format::Text;
  std::optional<int> to = {};  ///< step to end after
  std::string scene;           ///< file for the world as it is then, or ""
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_replay_options(CLI::App& command, ReplayFileOptions& options);

/// `atoll replay`: makes a recording's calls again and prints whether that came to the same. Throws Failure, with
/// Status::CheckFailed if it did not and Status::BadScene if the file can't be replayed.
void replay_file(const ReplayFileOptions& options);

}  // namespace atl::command
