#include "verify_options.h"

#include "../option_checks.h"

namespace atl::command {

void add_verify_options(CLI::App& command, VerifyOptions& options) {
  command.add_flag("--stability", options.stability,
                   "run stiff and extreme scenes, and hold penetration, drift, energy and the like to limits");
  command.add_option("--case", options.cases, "only the case of this name; may be given again")
      ->type_name("NAME")
      ->allow_extra_args(false);
  add_choice(command, "--format", {"text", "json"}, "what to print on stdout (default: text)",
             [&options](const std::string& name) { options.format = name == "json" ? Format::Json : Format::Text; });
}

}  // namespace atl::command
