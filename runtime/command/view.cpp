#include "view.h"

#include <atoll/playback.h>
#include <atoll/recording.h>
#include <atoll/scene.h>
#include <atoll/world.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <optional>
#include <sstream>

#include "failure.h"
#include "interrupt.h"
#include "names.h"
#include "option_checks.h"
#include "progress.h"
#include "simulation.h"
#include "standard_streams.h"
#include "view/film.h"
#include "view/film_page.h"
#include "view/gltf.h"
#include "view/still.h"
#include "view/vtk.h"

namespace atl::command {
namespace {

std::string file_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

using Watchers = std::vector<view::Watcher*>;

// Ends early where it is interrupted, with what there is by then.
void watch_recording(const ViewOptions& options, const Watchers& watchers) {
  try {
    Playback playback(options.scene.text, {.threads = options.threads, .simd = options.simd, .key_frame_bytes = 0});
    const std::int64_t to = std::min<std::int64_t>(options.to.value_or(max_steps), playback.steps());
    if (options.from > to) {
      throw Failure(Status::Usage, "--from: found " + std::to_string(options.from) + ", expected at most " +
                                       std::to_string(to) + ", the last step");
    }
    Progress progress(to);
    playback.seek(options.from);
    view::watch(playback, to, watchers, [&] {
      progress.update(playback.step());
      return !interrupted();
    });
  } catch (const Error& error) {
    throw Failure(Status::BadScene, error.what());
  }
}

void watch_scene(const ViewOptions& options, const Scene& scene, const Watchers& watchers) {
  World world = make_world(scene, options.threads);
  const std::vector<BodyId> ids = build_scene(scene, world);
  simulate(scene, world, ids, {.going = true, .watchers = watchers});
}

bool ends_in(const std::string& path, const char* ending) { return std::filesystem::path(path).extension() == ending; }
bool is_svg(const std::string& path) { return ends_in(path, ".svg"); }

OutputFile file_ending_in(const char* option, const std::string& path, const std::vector<const char*>& endings) {
  std::string expected;
  for (const char* ending : endings) {
    if (ends_in(path, ending)) return {option, path};
    expected += (expected.empty() ? "" : " or ") + std::string(ending);
  }
  throw Failure(Status::Usage,
                std::string(option) + ": found \"" + path + "\", expected a file that ends in " + expected);
}

// The path of a frame: step 12 of run.vtkhdf is run_000012.vtkhdf. Such names sort, and ParaView takes them for a
// series.
std::string frame_path(const std::string& path, std::int64_t step) {
  std::ostringstream number;
  number << '_' << std::setw(6) << std::setfill('0') << step;
  std::filesystem::path frame(path);
  frame.replace_filename(frame.stem().string() + number.str() + frame.extension().string());
  return frame.string();
}

void write_vtk_frame(const std::string& path, std::int64_t step, const std::vector<char>& bytes) {
  OutputFile("--vtk", frame_path(path, step)).write([&](std::ostream& out) {
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  });
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
  command.add_option("--gltf", options.gltf, "animated scene to write, as glTF 2.0, which 3D programs open")
      ->check(file_name())
      ->type_name("FILE.glb|.gltf")
      ->group(output);
  command.add_option("--vtk", options.vtk, "VTKHDF to write, a file a frame: FILE_000000.vtkhdf, ..., for ParaView")
      ->check(file_name())
      ->type_name("FILE.vtkhdf")
      ->group(output);
  command.add_option("--step", options.step, "of which state the picture is: after so many steps (default: the last)")
      ->check(integer_in(0, max_steps))
      ->type_name("STEP")
      ->group(output);
  command.add_option("--every", options.stride, "show every so many steps (default: 1)")
      ->check(integer_in(1, max_steps))
      ->type_name("STEPS")
      ->group(output);
  command.add_option("--from", options.from, "of a recording, begin after so many steps (default: 0)")
      ->check(integer_in(0, max_steps))
      ->type_name("STEP")
      ->group(output);
  command.add_option("--to", options.to, "of a recording, end after so many steps (default: all)")
      ->check(integer_in(0, max_steps))
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

namespace {

void check_vtk(const ViewOptions& options) {
  if (!view::has_vtk()) throw Failure(Status::Usage, "--vtk: this build writes no VTKHDF (ATOLL_BUILD_VTK is off)");
  (void)file_ending_in("--vtk", options.vtk, {".vtkhdf"});
  (void)OutputFile("--vtk", frame_path(options.vtk, options.from));
}

// All that is asked for of the run as a whole, told as it is written.
void watch(const ViewOptions& options, bool recorded, const Scene* scene) {
  std::optional<OutputFile> page, gltf;
  if (!options.page.empty()) page.emplace(page_file("--page", options.page));
  if (!options.gltf.empty()) gltf.emplace(file_ending_in("--gltf", options.gltf, {".glb", ".gltf"}));
  if (!options.vtk.empty()) check_vtk(options);
  const std::string name = recorded ? file_of(options.scene.text) : scene->name;
  view::Film film({.name = name, .place = options.place, .first_step = options.from, .stride = options.stride});
  view::GltfFilm gltf_film({.name = name, .first_step = options.from, .stride = options.stride});
  std::optional<view::VtkSeries> vtk;
  Watchers watchers;
  if (page) watchers.push_back(&film);
  if (gltf) watchers.push_back(&gltf_film);
  if (!options.vtk.empty()) {
    vtk.emplace(view::VtkOptions{.first_step = options.from, .stride = options.stride},
                [&](std::int64_t step, const std::vector<char>& bytes) { write_vtk_frame(options.vtk, step, bytes); });
    watchers.push_back(&*vtk);
  }
  if (recorded) {
    watch_recording(options, watchers);
  } else {
    watch_scene(options, *scene, watchers);
  }
  const auto frames = [](std::size_t count) { return plural(static_cast<std::int64_t>(count), "frame"); };
  if (page) {
    write_film(*page, film);
    std::cout << options.page << ": " << frames(film.frames()) << ", "
              << plural(static_cast<std::int64_t>(film.bodies().size()), "body", "bodies") << "\n";
  }
  if (gltf) {
    gltf->write([&](std::ostream& out) { gltf_film.write(out, ends_in(options.gltf, ".glb")); });
    std::cout << options.gltf << ": " << frames(gltf_film.frames()) << "\n";
  }
  if (vtk) {
    std::cout << frame_path(options.vtk, options.from) << " and on: " << frames(vtk->frames()) << "\n";
  }
}

}  // namespace

void view(const ViewOptions& options) {
  const bool whole = !options.page.empty() || !options.gltf.empty() || !options.vtk.empty();
  if (!whole && options.image.empty()) {
    throw Failure(Status::Usage, "view: found nothing to write, expected --page, --image, --gltf or --vtk");
  }
  std::optional<OutputFile> image;
  if (!options.image.empty()) image.emplace(file_ending_in("--image", options.image, {".png", ".svg"}));
  const bool recorded = is_recording(options.scene.text);
  std::optional<Scene> scene;
  if (!recorded) {
    scene = load(options.scene);
    scene->settings.simd = options.simd;
    if (!options.vtk.empty()) scene->settings.keep_contact_problem = true;
  }
  if (!recorded && (options.from > 0 || options.to)) {
    throw Failure(Status::Usage, "--from, --to: found a scene, expected a recording (a scene has --steps)");
  }
  if (whole) watch(options, recorded, scene ? &*scene : nullptr);
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
