#include "sweep_options.h"

#include <CLI/CLI.hpp>

#include "../option_checks.h"
#include "checks/tradeoff/axes.h"

namespace atl::command {
namespace {

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> values;
  for (std::size_t start = 0; start <= list.size();) {
    const std::size_t comma = std::min(list.find(',', start), list.size());
    values.push_back(list.substr(start, comma - start));
    start = comma + 1;
  }
  return values;
}

CLI::Validator list_of(const tradeoff::Axis& axis) {
  const auto check = [&axis](std::string& text) -> std::string {
    for (const std::string& value : split(text)) {
      if (!axis.accepts(value)) return "found \"" + value + "\", expected " + axis.expected;
    }
    return "";
  };
  return {check, "", "list"};
}

CLI::Validator not_empty() {
  return {[](std::string& text) -> std::string { return text.empty() ? "expected a name" : ""; }, "", "name"};
}

}  // namespace

void add_sweep_options(CLI::App& command, SweepOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll sweep stack --out DIR\n"
      "  atoll sweep pile wall:base=50 --substeps 2,4,8 --quick");
  command.add_option("SCENE", options.scenes, "scene files, or built-in scenes such as wall:base=100");
  command.add_flag("--analytic", options.analytic, "all built-in scenes that have a closed form");

  for (const tradeoff::Axis& axis : tradeoff::axes()) {
    const auto set = [&options, &axis](const std::string& text) { options.grid.lists[axis.name] = split(text); };
    command.add_option_function<std::string>(tradeoff::option_of(axis), set, axis.help)
        ->check(list_of(axis))
        ->type_name("LIST")
        ->group("Settings, lists by comma (default: see perf/README.md)");
  }

  const char* runs = "Runs";
  command.add_flag("--quick", options.grid.quick, "a coarse grid, fewer steps of large scenes, each timed once")
      ->group(runs);
  command
      .add_option("--steps", options.grid.steps, "steps at the scene's own dt (default: the scene's, fewer if large)")
      ->check(integer_in(1, max_steps))
      ->group(runs);
  command.add_option("--repeats", options.repeats, "timing runs of each setting (default: 3, with --quick 1)")
      ->check(integer_in(1, 1000))
      ->group(runs);
  command
      .add_option("--time", options.time,
                  "s of stepping that a timing run takes at least (default: 0.03, with --quick 0.02)")
      ->check(number_above_zero(60))
      ->group(runs);
  command.add_option("--seed", options.grid.seed, "seed of a scene's random content (default: 1)")
      ->check(seed_number())
      ->group(runs);

  command
      .add_flag("--frontier", options.frontier,
                "and how far each engine gets where towers and chains grow stiffer, with 1 to 16 substeps (--quick: 4)")
      ->group(runs);

  const char* peers = "Other engines";
  command.add_option("--peer", options.peers, "driver program of another engine; may be given again")
      ->check(not_empty())
      ->type_name("PROGRAM")
      ->allow_extra_args(false)
      ->group(peers);
  command
      .add_option("--peer-limit", options.peer_limit,
                  "s after which a run of a driver is stopped (default: 25, with --quick 6)")
      ->check(number_above_zero(86400))
      ->group(peers);

  command.add_option("--out", options.out, "directory for results.csv, results.json and index.html (default: sweep)")
      ->check(not_empty())
      ->type_name("DIR")
      ->group("Output");
  command
      .add_flag("--views", options.views,
                "and a page that plays each scene by its own settings, linked with index.html")
      ->group("Output");
}

}  // namespace atl::command
