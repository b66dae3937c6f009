// Scenes: a file, a file and the Wavefront file that it names as "mesh.obj", with a zero byte between them, or the name
// of a built-in scene with parameters. What is read is built, stepped and measured, and written as a scene file which
// is read to the same.

#include <atoll/error_meter.h>
#include <atoll/scene.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <string>
#include <string_view>

#include "few_steps.h"
#include "finding.h"
#include "scratch_file.h"
#include "target.h"

namespace {

using namespace atl;

constexpr std::size_t most_bodies = 2000;

bool is_builtin(std::string_view text) {
  const std::string_view name = text.substr(0, text.find(':'));
  return std::ranges::any_of(builtin_scenes(), [name](const BuiltinScene& scene) { return scene.name == name; });
}

// Whether no number in it has more than two digits before the point, or an exponent: a scene of few bodies.
bool has_small_numbers(const std::string& text) {
  static const std::regex large("(^|[^0-9.])[0-9]{3}|[0-9.][eE]");
  return !std::regex_search(text, large);
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Scene read(std::string_view text) {
  const std::string parameters(text.substr(std::min(text.find(':'), text.size())));
  if (is_builtin(text) && has_small_numbers(parameters)) return load_scene(text);
  const std::size_t zero = text.find('\0');
  if (zero == std::string_view::npos) return parse_scene(text, "input");
  const fuzz::ScratchFile mesh("mesh.obj");
  mesh.write(bytes_of(text.substr(zero + 1)));
  // "mesh.obj" is beside the scene, under a name of this process.
  std::string scene(text.substr(0, zero));
  const std::string name = "mesh.obj", own = std::filesystem::path(mesh.path()).filename().string();
  for (std::size_t at = scene.find(name); at != std::string::npos; at = scene.find(name, at + own.size())) {
    scene.replace(at, name.size(), own);
  }
  const fuzz::ScratchFile file("scene.json");
  file.write(bytes_of(scene));
  return load_scene(file.path());
}

void run(std::string_view text) {
  const Scene scene = read(text);
  if (scene.bodies.size() > most_bodies) return;
  const std::string written = scene_text(scene);
  std::string again;
  try {
    again = scene_text(parse_scene(written, "written"));
  } catch (const Error& error) {
    throw fuzz::Finding(std::string("a scene that was read and written is refused: ") + error.what());
  }
  fuzz::require(again == written, "a scene that was written and read is written otherwise");
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  if (scene.bodies.size() > 100) return fuzz::few_steps(world, 2);
  ErrorMeter meter(scene);
  for (const double time : {1.0, 2.0}) {
    apply_forces(scene, world, ids);
    fuzz::few_steps(world, 1);
    meter.observe(time * scene.dt, body_states(world, ids), contact_loads(world, ids));
  }
  meter.errors();
  meter.fell();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    run({reinterpret_cast<const char*>(data), size});
  } catch (const Error&) {
  }
  return 0;
}
