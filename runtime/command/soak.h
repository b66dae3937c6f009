#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "run_options.h"

namespace atl::command {

/// Options of `atoll soak`. It ends with the first of these limits that is reached.
struct SoakCommandOptions {
  std::optional<double> hours;
  std::optional<double> minutes;
  std::optional<int> steps;
  int threads = 1;
  std::uint64_t seed = 1;
  double interval = 60;    ///< s between two lines of the report
  std::string recordings;  ///< folder, or "" for one of its own
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_soak_options(CLI::App& command, SoakCommandOptions& options);

/// `atoll soak`: runs it and prints a line an interval, and what was lost. Throws Failure, with Status::CheckFailed if
/// a check failed or memory grew.
void soak(const SoakCommandOptions& options);

}  // namespace atl::command
