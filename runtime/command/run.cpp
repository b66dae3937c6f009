#include "run.h"

#include <iostream>
#include <iterator>
#include <optional>
#include <utility>

#include "failure.h"
#include "figures.h"
#include "interrupt.h"
#include "output_file.h"
#include "report.h"
#include "simulation.h"
#include "standard_streams.h"
#include "state/hex.h"
#include "view.h"
#include "view/film.h"

namespace atl::command {
namespace {

// The files of a run, known to be writable before a long simulation starts.
struct Outputs {
  std::optional<OutputFile> json;
  std::optional<OutputFile> final_state;
  std::optional<OutputFile> recording;
  std::optional<OutputFile> view;
};

void check_differ(const std::optional<OutputFile>& file, const char* option, const std::optional<OutputFile>& other,
                  const char* other_option) {
  if (!file || !other || file->target() != other->target()) return;
  throw Failure(Status::Usage, std::string(option) + ": found the file of " + other_option + ", expected another one");
}

Outputs check_outputs(const RunOptions& options) {
  Outputs outputs;
  if (!options.out.empty()) outputs.json.emplace("--out", options.out);
  if (!options.final_state.empty()) outputs.final_state.emplace("--final-state", options.final_state);
  if (!options.record.empty()) outputs.recording.emplace("--record", options.record);
  if (!options.view.empty()) outputs.view.emplace(page_file("--view", options.view));
  const std::pair<const char*, const std::optional<OutputFile>*> files[] = {{"--out", &outputs.json},
                                                                            {"--final-state", &outputs.final_state},
                                                                            {"--record", &outputs.recording},
                                                                            {"--view", &outputs.view}};
  for (std::size_t i = 1; i < std::size(files); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      check_differ(*files[i].second, files[i].first, *files[k].second, files[k].first);
  }
  return outputs;
}

// Does that with the recording, if there is one.
template <typename Act>
void with_recording(const Outputs& outputs, const Act& act) {
  if (!outputs.recording) return;
  try {
    act(outputs.recording->target());
  } catch (const Error& error) {
    throw Failure(Status::Usage, std::string("--record: ") + error.what());
  }
}

// All of what the scene is built of is in it.
void begin_recording(const Outputs& outputs, World& world) {
  with_recording(outputs, [&](const std::filesystem::path& path) { world.record(path); });
}

void end_recording(const Outputs& outputs, World& world) {
  with_recording(outputs, [&](const std::filesystem::path&) { world.stop_recording(); });
}

std::vector<BodyId> add_bodies(const Scene& scene, World& world) {
  try {
    return build_scene(scene, world);
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

void write_final_state(const Outputs& outputs, const Scene& scene, const std::vector<BodyId>& ids,
                       const RunResult& result) {
  if (!outputs.final_state) return;
  outputs.final_state->write([&](std::ostream& out) { result.final_state.write_csv(out, scene, ids); });
}

// Each file for itself: one that can't be written costs neither the others nor the results. What went wrong, or "".
std::string write_files(const Outputs& outputs, const Scene& scene, World& world, const std::vector<BodyId>& ids,
                        const RunResult& result, view::Film& film) {
  std::string failures;
  const auto try_to = [&](const auto& write) {
    try {
      write();
    } catch (const Failure& failure) {
      failures += (failures.empty() ? "" : "; ") + std::string(failure.what());
    }
  };
  try_to([&] { write_final_state(outputs, scene, ids, result); });
  try_to([&] { end_recording(outputs, world); });
  if (outputs.view) try_to([&] { write_film(*outputs.view, film); });
  if (outputs.json && !result.broken) {
    try_to([&] { outputs.json->write([&](std::ostream& out) { write_json(out, scene, world, result); }); });
  }
  return failures;
}

[[noreturn]] void fail_broken(const Scene& scene, const RunResult& result, const Outputs& outputs,
                              const std::string& failures) {
  const std::string more = result.lost.size() > 1 ? " (and " + std::to_string(result.lost.size() - 1) + " more)" : "";
  const char* state = outputs.final_state && failures.empty() ? "; --final-state has the state before that step" : "";
  throw Failure(Status::NonFinite, scene.name + ": " + lost_words(scene, result.lost.front()) + more + state +
                                       "; --keep-going goes on without it" + (failures.empty() ? "" : "; " + failures));
}

void print(const RunOptions& options, const Scene& scene, const World& world, const RunResult& result) {
  if (options.format == Format::Json) {
    write_json(std::cout, scene, world, result);
  } else {
    write_text(std::cout, scene, world, result);
    if (options.hash) std::cout << hash_text(result.hash) << "\n";
  }
  finish_output();
}

}  // namespace

void run(const RunOptions& options) {
  const Outputs outputs = check_outputs(options);
  const Scene scene = load(options);
  World world = make_world(scene, options.threads);
  begin_recording(outputs, world);
  const std::vector<BodyId> ids = add_bodies(scene, world);

  view::Film film({.name = scene.name});
  const RunResult result =
      simulate(scene, world, ids,
               {.final_state = outputs.final_state.has_value(),
                .errors = options.errors,
                .going = options.keep_going,
                .watchers = outputs.view ? std::vector<view::Watcher*>{&film} : std::vector<view::Watcher*>()});
  const std::string failures = write_files(outputs, scene, world, ids, result, film);
  if (result.broken) fail_broken(scene, result, outputs, failures);
  // Files first: a reader who has read enough ends all.
  print(options, scene, world, result);
  if (!failures.empty()) throw Failure(Status::Usage, failures);
  if (result.interrupted) throw interruption(scene.name, result.steps, scene.steps);
}

}  // namespace atl::command
