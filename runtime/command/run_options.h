#pragma once

#include <string>

#include "scene_options.h"

namespace atl::command {

enum class Format { Text, Json };

/// What `atoll run` was asked to do.
struct RunOptions {
  SceneOptions scene;
  int threads = 1;
  Simd simd = Simd::Auto;
  std::string out;          ///< file for the JSON object, or ""
  std::string final_state;  ///< file for the CSV, or ""
  Format format = Format::Text;
  bool errors = false;
  bool profile = false;
  bool hash = false;
  bool keep_going = false;
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_run_options(CLI::App& command, RunOptions& options);

/// The scene, with the settings that the options ask for. Throws SceneError.
Scene load(const RunOptions& options);

}  // namespace atl::command
