#pragma once

#include "run_options.h"

namespace atl::command {

/// Options of `atoll explain`.
struct ExplainOptions {
  SceneOptions scene;
  int threads = 1;
  Simd simd = Simd::Auto;
  Format format = Format::Text;
};

void add_explain_options(CLI::App& command, ExplainOptions& options);

/// Runs a scene and tells which features its steps needed, which they left out, why, and what memory is for what.
void explain(const ExplainOptions& options);

}  // namespace atl::command
