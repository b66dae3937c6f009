#pragma once

#include <atoll/scene.h>

#include <cstdint>
#include <optional>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11 chose it
class App;
class Option;
}  // namespace CLI

namespace atl::command {

/// The scene to simulate, and its settings. An empty optional leaves the choice to the scene.
struct SceneOptions {
  std::string text;  ///< see load_scene()
  std::uint64_t seed = 1;
  bool allow_outside = false;  ///< its folder, for mesh files
  std::optional<int> steps;
  std::optional<double> dt;  ///< s
  std::optional<int> substeps;
  std::optional<ErrorTarget> target;  ///< its errors
  std::optional<int> max_substeps;    ///< of a target
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
};

/// Declares them, to be parsed into `options`, which has to outlive the parsing. Returns that of the scene itself,
/// which may be left out unless it is made to be required.
CLI::Option* add_scene_options(CLI::App& command, SceneOptions& options);

/// The scene, with what it says overridden by what the options say. Throws SceneError, and Failure on
/// options that don't go together.
Scene load(const SceneOptions& options);

}  // namespace atl::command
