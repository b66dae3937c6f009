#pragma once

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>

#include "checks/tradeoff/tune.h"
#include "run_options.h"

namespace atl::command {

/// Options of `atoll tune`.
struct TuneOptions {
  std::string scene;    ///< see load_scene()
  double error = 1e-3;  ///< m
  std::uint64_t seed = 1;
  std::optional<int> steps;  ///< the scene's own where there is none
  std::optional<int> repeats;
  std::optional<double> time;  ///< s
  Format format = Format::Text;
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_tune_options(CLI::App& command, TuneOptions& options);

/// `atoll tune`: looks for the settings, tells each trial on stderr, and prints them. Throws Failure, with
/// Status::CheckFailed where none hold the error.
void tune(const TuneOptions& options);

/// Writes the tuning as one JSON object, whose keys and their order are part of the command's interface.
void write_tuning_json(std::ostream& out, const tradeoff::ScenePlan& plan, double error,
                       const tradeoff::Tuning& tuning);

}  // namespace atl::command
