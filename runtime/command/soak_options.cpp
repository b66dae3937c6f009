#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "option_checks.h"
#include "soak.h"

namespace atl::command {

void add_soak_options(CLI::App& command, SoakCommandOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll soak --hours 8 --recordings DIR\n"
      "  atoll soak --steps 2000 --seed 7");
  const char* length = "Length (the first that is reached; one at least)";
  command.add_option("--hours", options.hours, "hours of wall time")->check(number_above_zero())->group(length);
  command.add_option("--minutes", options.minutes, "minutes of wall time")->check(number_above_zero())->group(length);
  command.add_option("--steps", options.steps, "steps of 1/60 s")->check(integer_in(1, max_steps))->group(length);

  const unsigned cores = std::thread::hardware_concurrency();  // 0 where it is unknown
  options.threads = std::clamp(static_cast<int>(cores), 1, max_threads);
  command
      .add_option("--threads", options.threads,
                  "worker threads (default: all cores); the world that runs beside it has 1, or 2 if that has 1")
      ->check(integer_in(1, max_threads));
  command.add_option("--seed", options.seed, "seed of all that happens (default: 1)")->check(seed_number());
  command.add_option("--interval", options.interval, "s between two lines (default: 60)")->check(number_above_zero());
  command
      .add_option("--recordings", options.recordings,
                  "folder for recordings while they are needed, where those of lost bodies and failed checks stay "
                  "(default: a temporary one)")
      ->check(file_name())
      ->type_name("DIR");
}

}  // namespace atl::command
