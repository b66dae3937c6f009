#include "replay_options.h"

#include <CLI/CLI.hpp>

#include "option_checks.h"

namespace atl::command {

void add_replay_options(CLI::App& command, ReplayFileOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll run pile --record pile.rec\n"
      "  atoll replay pile.rec --threads 1");
  command.add_option("FILE", options.path, "recording, as of atoll run --record")->check(file_name())->required();
  add_machine_options(command, options.threads, options.simd);
  add_format_option(command, options.format);
}

}  // namespace atl::command
