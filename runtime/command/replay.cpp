#include "replay.h"

#include <atoll/playback.h>
#include <atoll/scene.h>
#include <atoll/world.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <optional>

#include "failure.h"
#include "interrupt.h"
#include "option_checks.h"
#include "output_file.h"
#include "progress.h"
#include "replay_report.h"
#include "standard_streams.h"

namespace atl::command {
namespace {

// Throws if the machine lacks the threads or the instruction set; tested ahead, so that the file isn't blamed for it.
void check_machine(const ReplayFileOptions& options) {
  try {
    const World world({.threads = options.threads, .settings = {.simd = options.simd}});
  } catch (const Error& error) {
    throw Failure(Status::Usage, error.what());
  }
}

ReplayResult replay_with_progress(const ReplayFileOptions& options) {
  std::optional<Progress> progress;
  const auto show = [&](std::int64_t steps, std::int64_t of) {
    if (!progress) progress.emplace(of);
    progress->update(steps);
  };
  try {
    std::int64_t done = 0;
    const auto count = [&](std::int64_t steps, std::int64_t of) { show(done = steps, of); };
    const auto stop = [&] { return interrupted() || (options.to && done >= *options.to); };
    return replay(options.path, {.threads = options.threads, .simd = options.simd, .on_step = count, .stop = stop});
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

std::string scene_at(const ReplayFileOptions& options, std::int64_t step) {
  try {
    Playback playback(options.path, {.threads = options.threads, .simd = options.simd, .key_frame_bytes = 0});
    playback.seek(step);
    Scene scene = scene_of(playback.world());
    if (step > 0) scene.dt = playback.dt();
    return scene_text(scene);
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

}  // namespace

void add_replay_options(CLI::App& command, ReplayFileOptions& options) {
  command.footer(
      "Examples:\n"
      "  atoll run pile --record pile.rec\n"
      "  atoll replay pile.rec --threads 1\n"
      "  atoll replay pile.rec --to 120 --scene pile-at-2s.json");
  command.add_option("FILE", options.path, "recording, as of atoll run --record")->check(file_name())->required();
  command.add_option("--to", options.to, "end after so many steps (default: all)")
      ->check(integer_in(1, max_steps))
      ->type_name("STEP");
  command.add_option("--scene", options.scene, "write the world as it is then to this file, to edit and run")
      ->check(file_name())
      ->type_name("FILE.json");
  add_machine_options(command, options.threads, options.simd);
  add_format_option(command, options.format);
}

void replay_file(const ReplayFileOptions& options) {
  check_machine(options);
  std::optional<OutputFile> scene;
  if (!options.scene.empty()) scene.emplace("--scene", options.scene);
  const ReplayResult result = replay_with_progress(options);
  if (options.format == Format::Json) {
    write_replay_json(std::cout, options, result);
  } else {
    write_replay_text(std::cout, options, result);
  }
  finish_output();
  if (result.divergence) {
    throw Failure(Status::CheckFailed,
                  options.path + ": the replay differs from what was recorded: " + first_words(*result.divergence));
  }
  if (scene) scene->write([&](std::ostream& out) { out << scene_at(options, result.steps); });
  if (result.steps < result.recorded_steps && interrupted()) {
    throw interruption(options.path, result.steps, result.recorded_steps);
  }
}

}  // namespace atl::command
