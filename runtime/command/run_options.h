#pragma once

#include <string>

#include "scene_options.h"

namespace atl::command {

enum class Format { Text, Json };

/// Options of `atoll run`.
struct RunOptions {
  SceneOptions scene;
  int threads = 1;
  Simd simd = Simd::Auto;
  std::string out;          ///< file for the JSON object, or ""
  std::string final_state;  ///< file for the CSV, or ""
  std::string record;       ///< file for a recording, or ""
  std::string view;         ///< file for a page that plays the run, or ""
  Format format = Format::Text;
  bool errors = false;
  bool profile = false;
  bool run_everything = false;
  bool hash = false;
  bool keep_going = false;
};

/// Options that other commands have, too. What they are parsed into has to outlive the parsing.
void add_machine_options(CLI::App& command, int& threads, Simd& simd);
void add_format_option(CLI::App& command, Format& format);

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_run_options(CLI::App& command, RunOptions& options);

/// The scene, with the settings that the options ask for. Throws SceneError.
Scene load(const RunOptions& options);

}  // namespace atl::command
