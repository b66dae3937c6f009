#pragma once

#include <optional>
#include <string>
#include <vector>

#include "checks/tradeoff/grid.h"

namespace CLI {  // NOLINT(readability-identifier-naming): CLI11 chose it
class App;
}

namespace atl::command {

/// Options of `atoll sweep`.
struct SweepOptions {
  std::vector<std::string> scenes;
  bool analytic = false;  ///< and all built-in scenes that have a closed form
  tradeoff::GridOptions grid = {};
  bool frontier = false;             ///< and how far each engine gets on stiff_ladders()
  std::vector<std::string> peers;    ///< driver programs
  std::optional<double> peer_limit;  ///< s that one run of a driver may take
  std::optional<int> repeats;        ///< timing rounds
  std::optional<double> time;        ///< s, the least that one timing run spends in steps
  bool views = false;                ///< and a page that plays each scene
  std::string out = "sweep";
};

/// Declares the options, to be parsed into `options`, which has to outlive the parsing.
void add_sweep_options(CLI::App& command, SweepOptions& options);

}  // namespace atl::command
