#include <CLI/CLI.hpp>

#include "checks/tradeoff/number_text.h"
#include "option_checks.h"
#include "tune.h"

namespace atl::command {

void add_tune_options(CLI::App& command, TuneOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll tune wall --error 1mm\n"
      "  atoll tune bridge --error 0.1mm --steps 600 > settings.json");
  command
      .add_option("SCENE", options.scene, "scene file, or a built-in scene such as wall:base=100 (see atoll scenes)")
      ->required();
  command
      .add_option_function<std::string>(
          "--error", [&options](const std::string& text) { options.error = tradeoff::parse_metres(text); },
          "what penetrations and gaps of joints are to stay below once the scene rests, in the last quarter of its "
          "steps: as 1mm or 0.001, in m (default: 1mm)")
      ->check(length_above_zero())
      ->type_name("LENGTH");
  command.add_option("--steps", options.steps, "steps to judge by (default: the scene's)")
      ->check(integer_in(1, max_steps));
  command.add_option("--repeats", options.repeats, "timing runs of each that holds (default: 3)")
      ->check(integer_in(1, 1000));
  command.add_option("--time", options.time, "s of stepping in one of these, at least (default: 0.03)")
      ->check(number_above_zero(60));
  command.add_option("--seed", options.seed, "seed of a scene's random content (default: 1)")->check(seed_number());
  add_format_option(command, options.format);
}

}  // namespace atl::command
