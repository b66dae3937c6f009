#include "view.h"

#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/scene.h>
#include <atoll/world.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <optional>

#include "failure.h"
#include "interrupt.h"
#include "names.h"
#include "option_checks.h"
#include "progress.h"
#include "simulation.h"
#include "standard_streams.h"
#include "view/film.h"
#include "view/film_page.h"
#include "view/still.h"

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

void film_scene(const ViewOptions& options, const Scene& scene, view::Film& film) {
  World world = make_world(scene, options.threads);
  const std::vector<BodyId> ids = build_scene(scene, world);
  simulate(scene, world, ids, {.going = true, .film = &film});
}

bool is_svg(const std::string& path) { return std::filesystem::path(path).extension() == ".svg"; }

OutputFile image_file(const std::string& path) {
  if (!is_svg(path) && std::filesystem::path(path).extension() != ".png") {
    throw Failure(Status::Usage, "--image: found \"" + path + "\", expected a file that ends in .png or .svg");
  }
  return {"--image", path};
}

void draw(const ViewOptions& options, const World& world, std::int64_t step, const OutputFile& file) {
  const view::Still still(world);
  file.write([&](std::ostream& out) { is_svg(options.image) ? still.write_svg(out) : still.write_png(out); });
  std::cout << options.image << ": after step " << step << "\n";
}

[[noreturn]] void fail_step(int found, std::int64_t last) {
  throw Failure(Status::Usage, "--step: found " + std::to_string(found) + ", expected at most " + std::to_string(last) +
                                   ", the last step");
}

void draw_recording(const ViewOptions& options, const OutputFile& file) {
  try {
    Playback playback(options.scene.text, {.threads = options.threads, .simd = options.simd, .key_frame_bytes = 0});
    if (options.step && *options.step > playback.steps()) fail_step(*options.step, playback.steps());
    playback.seek(options.step ? *options.step : playback.steps());
    draw(options, playback.world(), playback.step(), file);
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

void draw_scene(const ViewOptions& options, const Scene& scene, const OutputFile& file) {
  if (options.step && *options.step > scene.steps) fail_step(*options.step, scene.steps);
  World world = make_world(scene, options.threads);
  const std::vector<BodyId> ids = build_scene(scene, world);
  const int last = options.step.value_or(scene.steps);
  Progress progress(last);
  int step = 0;
  for (; step < last && !interrupted(); ++step) {
    apply_forces(scene, world, ids);
    world.step(scene.dt);
    progress.update(step + 1);
  }
  draw(options, world, step, file);
}

}  // namespace

void add_view_options(CLI::App& command, ViewOptions& options) {
  add_scene_options(command, options.scene)->required()->description("scene as of atoll run, or recording");
  add_machine_options(command, options.threads, options.simd);
  const char* output = "Output";
  command.add_option("-o,--page", options.page, "page to write")
      ->check(file_name())
      ->type_name("FILE.html")
      ->group(output);
  command.add_option("--image", options.image, "picture to write, as the ending says")
      ->check(file_name())
      ->type_name("FILE.png|.svg")
      ->group(output);
  command.add_option("--step", options.step, "of which state the picture is: after so many steps (default: the last)")
      ->check(integer_in(0, most_steps))
      ->type_name("STEP")
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
      "  atoll view pile:bodies=500 --image pile.png --step 100\n"
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
  if (options.page.empty() && options.image.empty()) {
    throw Failure(Status::Usage, "view: found nothing to write, expected --page or --image");
  }
  std::optional<OutputFile> page, image;
  if (!options.page.empty()) page.emplace(page_file("--page", options.page));
  if (!options.image.empty()) image.emplace(image_file(options.image));
  const bool recorded = is_recording(options.scene.text);
  std::optional<Scene> scene;
  if (!recorded) {
    scene = load(options.scene);
    scene->settings.simd = options.simd;
  }
  if (!recorded && (options.from > 0 || options.to)) {
    throw Failure(Status::Usage, "--from, --to: found a scene, expected a recording (a scene has --steps)");
  }
  if (page) {
    view::Film film({.name = recorded ? file_of(options.scene.text) : scene->name,
                     .place = options.place,
                     .first_step = options.from,
                     .stride = options.stride});
    if (recorded) {
      film_recording(options, film);
    } else {
      film_scene(options, *scene, film);
    }
    write_film(*page, film);
    std::cout << options.page << ": " << plural(static_cast<std::int64_t>(film.frames()), "frame") << ", "
              << plural(static_cast<std::int64_t>(film.bodies().size()), "body", "bodies") << "\n";
  }
  if (image) {
    if (recorded) {
      draw_recording(options, *image);
    } else {
      draw_scene(options, *scene, *image);
    }
  }
  finish_output();
}

}  // namespace atl::command
