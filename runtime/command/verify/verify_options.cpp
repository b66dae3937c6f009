#include "verify_options.h"

#include <algorithm>

#include "../option_checks.h"

namespace atl::command {
namespace {

CLI::Validator simd_name() {
  const std::vector<std::string> names = {"all", "auto", "portable", "sse4", "avx2", "avx512"};
  const auto check = [names](std::string& text) -> std::string {
    for (const std::string& name : names) {
      if (text == name) return "";
    }
    return "found \"" + text + "\", expected all|auto|portable|sse4|avx2|avx512, or some of these with commas";
  };
  return {check, "", "instruction set"};
}

void add_determinism_options(CLI::App& command, VerifyOptions& options) {
  const std::vector<CLI::Option*> before = command.get_options();
  CLI::Option* scene = add_scene_options(command, options.scene);
  const char* machine = "Machine (none of these may change a bit of the result)";
  command
      .add_option("--threads", options.threads, "numbers of worker threads, the first for the run to hold others to")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(integer_in(1, max_threads))
      ->type_name("N,N...")
      ->default_str("1,2,4")
      ->group(machine);
  command
      .add_option("--simd", options.simds, "vector instructions of the solver, the first likewise; all: this machine's")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->check(simd_name())
      ->type_name("all|NAME,NAME...")
      ->default_str("all")
      ->group(machine);
  command
      .add_flag(
          "--restore", options.restore,
          "each of these runs also with its state saved ahead of some steps, and restored into the same world after "
          "steps on, and into an empty one")
      ->group(machine);
  std::vector<const CLI::Option*> of_scenes;
  for (const CLI::Option* option : command.get_options()) {
    const bool is_old = std::find(before.begin(), before.end(), option) != before.end();
    if (option != scene && !is_old) of_scenes.push_back(option);
  }
  // CLI11's needs() would say so in the help of each.
  command.callback([=] {
    for (const CLI::Option* option : of_scenes) {
      if (option->count() > 0 && scene->count() == 0) throw CLI::RequiresError(option->get_name(), scene->get_name());
    }
  });
}

}  // namespace

void add_verify_options(CLI::App& command, VerifyOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll verify pile --steps 60 --threads 1,2,4\n"
      "  atoll verify --stability");
  add_determinism_options(command, options);
  const char* suites = "Stability and physics, instead of a scene";
  command
      .add_flag("--stability", options.stability,
                "run stiff and extreme scenes, and hold penetration, drift, energy and the like to limits")
      ->group(suites);
  command
      .add_flag("--physics", options.physics,
                "run motions that are known, and hold them against closed forms and published values")
      ->group(suites);
  command
      .add_flag("--refine", options.refine, "with --physics: also in steps of a 4th, a 16th and a 64th, but for grains")
      ->group(suites);
  command.add_option("--case", options.cases, "only the case of this name; may be given again")
      ->type_name("NAME")
      ->allow_extra_args(false)
      ->group(suites);
  add_format_option(command, options.format);
}

}  // namespace atl::command
