#include "run_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "names.h"
#include "option_checks.h"

namespace atl::command {
namespace {

CLI::Validator file_name() {
  const auto check = [](std::string& text) -> std::string { return text.empty() ? "expected a file name" : ""; };
  return {check, "", "file name"};
}

}  // namespace

void add_run_options(CLI::App& command, RunOptions& options) {
  const unsigned cores = std::thread::hardware_concurrency();  // 0 where it is unknown
  options.threads = std::clamp(static_cast<int>(cores), 1, most_threads);

  add_scene_options(command, options.scene)->required();

  const char* machine = "Machine (none of these changes a bit of the result)";
  command.add_option("--threads", options.threads, "worker threads (default: all cores)")
      ->check(integer_in(1, most_threads))
      ->group(machine);
  add_choice(command, "--simd", {"auto", "portable", "sse4", "avx2", "avx512"}, "vector instructions of the solver",
             [&options](const std::string& name) { options.simd = simd_named(name); })
      ->group(machine);

  const char* output = "Output";
  command.add_option("--out", options.out, "write the results as one JSON object to this file")
      ->check(file_name())
      ->type_name("FILE")
      ->group(output);
  command
      .add_option("--final-state", options.final_state,
                  "write the final pose and velocity of every body to this CSV file")
      ->check(file_name())
      ->type_name("FILE")
      ->group(output);
  const auto set_format = [&options](const std::string& name) {
    options.format = name == "json" ? Format::Json : Format::Text;
  };
  add_choice(command, "--format", {"text", "json"}, "what to print on stdout (default: text)", set_format)
      ->group(output);
  command
      .add_flag("--errors", options.errors,
                "measure the errors of every step, contact residual and closed form among them; takes time")
      ->group(output);
  command
      .add_flag("--profile", options.profile,
                "tell what the solver spends its time on; takes a little time, and changes no bit")
      ->group(output);
  command
      .add_flag(
          "--keep-going", options.keep_going,
          "go on without bodies whose state becomes non-finite or absurd, and list them, instead of exit status 4")
      ->group(output);
  command.add_flag("--hash", options.hash, "with text, end with a line that holds the state hash alone")->group(output);
}

Scene load(const RunOptions& options) {
  Scene scene = load(options.scene);
  scene.settings.keep_contact_problem = options.errors;
  scene.settings.profile = options.profile;
  scene.settings.simd = options.simd;
  return scene;
}

}  // namespace atl::command
