#pragma once

#include <string>

#include "run_options.h"

namespace atl::command {

/// Options of `atoll bisect`.
struct BisectOptions {
  std::string first, second;  ///< recordings
  int threads = 1;
  Simd simd = Simd::Auto;
  std::string view;  ///< file for a page of the second around the step, or ""
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_bisect_options(CLI::App& command, BisectOptions& options);

/// `atoll bisect`: tells in which step two recordings part, in what of it, and of which bodies. Throws Failure, with
/// Status::CheckFailed if they do.
void bisect(const BisectOptions& options);

}  // namespace atl::command
