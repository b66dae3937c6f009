#pragma once

#include <string>
#include <vector>

#include "../run_options.h"

namespace atl::command {

/// What `atoll verify` was asked to do.
struct VerifyOptions {
  bool stability = false;
  std::vector<std::string> cases;  ///< names; all where there is none
  Format format = Format::Text;
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_verify_options(CLI::App& command, VerifyOptions& options);

}  // namespace atl::command
