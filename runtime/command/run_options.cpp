#include "run_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "names.h"
#include "option_checks.h"

namespace atl::command {

void add_machine_options(CLI::App& command, int& threads, Simd& simd) {
  const unsigned cores = std::thread::hardware_concurrency();  // 0 where it is unknown
  threads = std::clamp(static_cast<int>(cores), 1, max_threads);
  const char* machine = "Machine (none of these changes a bit of the result)";
  command.add_option("--threads", threads, "worker threads (default: all cores)")
      ->check(integer_in(1, max_threads))
      ->group(machine);
  add_choice(command, "--simd", {"auto", "portable", "sse4", "avx2", "avx512"}, "vector instructions of the solver",
             [&simd](const std::string& name) { simd = simd_named(name); })
      ->group(machine);
}

void add_format_option(CLI::App& command, Format& format) {
  add_choice(command, "--format", {"text", "json"}, "what to print on stdout (default: text)",
             [&format](const std::string& name) { format = name == "json" ? Format::Json : Format::Text; })
      ->group("Output");
}

void add_run_options(CLI::App& command, RunOptions& options) {
  add_scene_options(command, options.scene)->required();

  add_machine_options(command, options.threads, options.simd);

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
  command
      .add_option("--record", options.record,
                  "write all that is done to the world, and hashes of what it comes to, to this file, for atoll replay")
      ->check(file_name())
      ->type_name("FILE")
      ->group(output);
  command
      .add_option("--view", options.view,
                  "write a page that plays the run, to look at in a browser, to this file (see atoll view)")
      ->check(file_name())
      ->type_name("FILE.html")
      ->group(output);
  add_format_option(command, options.format);
  command
      .add_flag("--errors", options.errors,
                "measure the errors of every step, contact residual and closed form among them; takes time")
      ->group(output);
  command
      .add_flag(
          "--profile", options.profile,
          "print all counts and features, and what the solver spends its time on; takes a little time, and changes "
          "no bit")
      ->group(output);
  command
      .add_flag("--run-everything", options.run_everything,
                "leave nothing out that the scene does not need, to see what leaving out saves; changes no bit")
      ->group(output);
  command
      .add_flag(
          "--keep-going", options.keep_going,
          "go on without bodies whose state becomes non-finite or absurd, and list them, instead of exit status 4")
      ->group(output);
  command.add_flag("--hash", options.hash, "with text, end with a line that holds the state hash alone")->group(output);
  command.footer(
      "Examples:\n"
      "  atoll run pile --threads 2\n"
      "  atoll run wall:base=100 --dt 1/120 --substeps 8 --errors\n"
      "  atoll run my_scene.json --format json --out results.json");
}

Scene load(const RunOptions& options) {
  Scene scene = load(options.scene);
  scene.settings.keep_contact_problem = options.errors;
  scene.settings.profile = options.profile;
  scene.settings.run_everything = options.run_everything;
  scene.settings.simd = options.simd;
  return scene;
}

}  // namespace atl::command
