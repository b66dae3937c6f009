#include "view.h"

#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/scene.h>
#include <atoll/world.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "failure.h"
#include "interrupt.h"
#include "names.h"
#include "option_checks.h"
#include "progress.h"
#include "simulation.h"
#include "standard_streams.h"
#include "view/film.h"
#include "view/film_page.h"

namespace atl::command {
namespace {

std::string file_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

// Ends early where it is interrupted, with what there is by then.
void film_recording(const ViewOptions& options, view::Film& film) {
  try {
    Playback playback(options.scene.text, {.threads = options.threads, .simd = options.simd, .key_frame_bytes = 0});
    const std::int64_t to = std::min<std::int64_t>(options.to.value_or(most_steps), playback.steps());
    if (options.from > to) {
      throw Failure(Status::Usage, "--from: found " + std::to_string(options.from) + ", expected at most " +
                                       std::to_string(to) + ", the last step");
    }
    Progress progress(to);
    playback.seek(options.from);
    film.begin(playback.world());
    while (playback.step() < to && playback.advance()) {
      film.add(playback.world(), playback.report(), playback.dt());
      progress.update(playback.step());
      if (interrupted()) return;
    }
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

void film_scene(const ViewOptions& options, Scene scene, view::Film& film) {
  scene.settings.simd = options.simd;
  std::optional<World> world;
  try {
    world.emplace(WorldDef{.gravity = scene.gravity, .threads = options.threads, .settings = scene.settings});
  } catch (const Error& error) {
    throw Failure(Status::Usage, error.what());
  }
  const std::vector<BodyId> ids = build_scene(scene, *world);
  simulate(scene, *world, ids, {.going = true, .film = &film});
}

}  // namespace

void add_view_options(CLI::App& command, ViewOptions& options) {
  add_scene_options(command, options.scene)->required()->description("scene as of atoll run, or recording");
  add_machine_options(command, options.threads, options.simd);
  const char* output = "Output";
  command.add_option("-o,--page", options.page, "page to write")
      ->check(file_name())
      ->type_name("FILE.html")
      ->required()
      ->group(output);
  command.add_option("--every", options.stride, "show every so many steps (default: 1)")
      ->check(integer_in(1, most_steps))
      ->type_name("STEPS")
      ->group(output);
  command.add_option("--from", options.from, "of a recording, begin after so many steps (default: 0)")
      ->check(integer_in(0, most_steps))
      ->type_name("STEP")
      ->group(output);
  command.add_option("--to", options.to, "of a recording, end after so many steps (default: all)")
      ->check(integer_in(0, most_steps))
      ->type_name("STEP")
      ->group(output);
  command.footer(
      "The page holds all it needs, and is looked at in any browser. After a # its address may say what it shows "
      "first,\n"
      "as run.html#step=120&body=7&colour=force&contacts.\n"
      "\nExamples:\n"
      "  atoll view ragdolls -o ragdolls.html\n"
      "  atoll run pile --record pile.rec && atoll view pile.rec -o pile.html");
}

OutputFile page_file(const char* option, const std::string& path) {
  if (!view::has_page()) {
    throw Failure(Status::Usage, std::string(option) + ": this build has no page (ATOLL_BUILD_PAGE is off)");
  }
  return {option, path};
}

void write_film(const OutputFile& file, view::Film& film) {
  file.write([&](std::ostream& out) { write_page(out, film); });
}

void view(const ViewOptions& options) {
  const OutputFile page = page_file("--page", options.page);
  const bool recorded = is_recording(options.scene.text);
  std::optional<Scene> scene;
  if (!recorded) scene = load(options.scene);
  if (!recorded && (options.from > 0 || options.to)) {
    throw Failure(Status::Usage, "--from, --to: found a scene, expected a recording (a scene has --steps)");
  }
  view::Film film({.name = recorded ? file_of(options.scene.text) : scene->name,
                   .place = options.place,
                   .first_step = options.from,
                   .stride = options.stride});
  if (recorded) {
    film_recording(options, film);
  } else {
    film_scene(options, *scene, film);
  }
  write_film(page, film);
  std::cout << options.page << ": " << plural(static_cast<std::int64_t>(film.frames()), "frame") << ", "
            << plural(static_cast<std::int64_t>(film.bodies().size()), "body", "bodies") << "\n";
  finish_output();
}

}  // namespace atl::command
