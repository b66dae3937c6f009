#pragma once

#include <atoll/scene.h>

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11 chose it
class App;
}

namespace atl::command {

enum class Format { Text, Json };

/// What `atoll run` was asked to do. An empty optional leaves the choice to the scene.
struct RunOptions {
  std::string scene;
  std::optional<int> steps;
  std::optional<double> dt;  ///< s
  int threads = 1;
  std::optional<int> substeps;
  std::optional<int> iterations;
  std::optional<int> relax_iterations;
  std::optional<FrictionModel> friction;
  std::optional<Stabilisation> stabilisation;
  std::optional<double> correction;
  std::optional<double> slop;       ///< m
  std::optional<double> tolerance;  ///< m/s
  std::optional<ContactSolver> contact_solver;
  std::optional<JointSolver> joint_solver;
  std::optional<double> joint_hertz;  ///< Hz
  bool no_warm_start = false;
  bool sleeping = false;
  Simd simd = Simd::Auto;
  std::uint64_t seed = 1;
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

/// Overrides what the scene says by what the options say.
void apply(const RunOptions& options, Scene& scene);

}  // namespace atl::command
