// Scenes: a file, a file and the Wavefront file that it names as "mesh.obj", with a zero byte between them, or a name
// of a built-in scene with parameters. What is read is built, stepped and measured, and written as a scene file which
// is read to the same and steps to the same bits.

#include <atoll/error_meter.h>
#include <atoll/scene.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "few_steps.h"
#include "finding.h"
#include "mutate_json.h"
#include "scratch_file.h"
#include "target.h"

namespace {

using namespace atl;

constexpr std::size_t max_bodies = 2000;

// And no path of a file.
bool is_name(std::string_view text) {
  return !text.empty() && text.front() >= 'a' && text.front() <= 'z' && text.find('/') == std::string_view::npos;
}

// The value of a parameter in a text such as "name:count=20,speed=3".
double value_of(const SceneParameter& parameter, std::string_view text) {
  const std::string item = parameter.name + "=";
  double value = parameter.value;
  for (std::size_t at = text.find_first_of(":,"); at != std::string_view::npos; at = text.find_first_of(":,", at + 1)) {
    if (!text.substr(at + 1).starts_with(item)) continue;
    std::from_chars(text.data() + at + 1 + item.size(), text.data() + text.size(), value);
  }
  return value;
}

// True if all counts of a built-in scene are so small that it runs in no time, or so large that it is refused.
bool has_small_counts(std::string_view text) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    if (scene.name != text.substr(0, text.find(':'))) continue;
    return std::ranges::all_of(scene.parameters, [text](const SceneParameter& parameter) {
      const double value = value_of(parameter, text);
      return !parameter.integer || value <= std::max(20.0, parameter.min) || value > parameter.max;
    });
  }
  return true;
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

Scene read(std::string_view text) {
  if (is_name(text)) {
    if (!has_small_counts(text)) throw Error("a scene of too many bodies to be tried");
    return load_scene(text);
  }
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

// By way of a file.
Scene read_again(const Scene& scene) {
  const fuzz::ScratchFile file("again.json");
  const std::string written = scene_text(scene);
  write_scene(scene, file.path());
  try {
    Scene again = load_scene(file.path());
    if (scene.name.empty()) again.name = {};  // a scene without a name has its file's
    fuzz::require(scene_text(again) == written, "a scene that was written and read is written otherwise");
    return again;
  } catch (const SceneError& error) {
    throw fuzz::Finding(std::string("a scene that was read and written is refused: ") + error.what());
  }
}

// JSON has no words for what is no number.
void check_refused(Scene scene) {
  scene.bodies.back().def.position.y() = std::numeric_limits<double>::quiet_NaN();
  fuzz::require_refused("a scene file with what is no number", [&] { scene_text(scene); });
}

World built(const Scene& scene, std::vector<BodyId>& ids) {
  World world({.gravity = scene.gravity, .settings = scene.settings});
  ids = build_scene(scene, world);
  return world;
}

// Bodies are built where the scene has them, to rounding.
void check_places(const Scene& scene, const World& world, const std::vector<BodyId>& ids) {
  const std::vector<PlacedShape> planned = placed_shapes(scene), placed = placed_shapes(scene, world, ids);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const Vector3 &from = planned[i].pose.position, &to = placed[i].pose.position;
    const double scale =
        std::max({1.0, from.cwiseAbs().maxCoeff(), world.centre_of_mass(ids[i]).cwiseAbs().maxCoeff()});
    fuzz::require((from - to).cwiseAbs().maxCoeff() <= 1e-12 * scale, "a body is built elsewhere");
  }
}

// After two steps, and as if the scene's run were over then.
void measure(const Scene& scene, World& world, const std::vector<BodyId>& ids, bool is_builtin) {
  ErrorMeter meter(scene);
  for (const int steps : {1, 2, 2 + scene.steps / 2, 2 + scene.steps}) {
    apply_forces(scene, world, ids);
    fuzz::few_steps(world, 1);
    meter.observe(steps * scene.dt, body_states(world, ids),
                  meter.needs_loads() ? contact_loads(world, ids) : std::vector<ContactLoad>());
  }
  const std::vector<ErrorMeasure> errors = meter.errors();
  for (const ErrorMeasure& error : errors) {
    const bool is_finite = std::isfinite(error.value) && error.value >= 0;
    fuzz::require(is_finite || !is_builtin, scene.name + ": " + error.name + " is " + std::to_string(error.value));
  }
  fuzz::require(!scene.closed_form || errors.front().name == "analytic_error", "a closed form tells of no error");
  fuzz::require(scene.starts_at_rest || !meter.fell(), "a body fell that had no place to rest");
}

void run(std::string_view text) {
  const Scene scene = read(text);
  if (scene.bodies.size() > max_bodies) return;
  const Scene again = read_again(scene);
  std::vector<BodyId> ids, ids_again;
  World world = built(scene, ids), world_again = built(again, ids_again);
  fuzz::require(world.state_hash() == world_again.state_hash(), "a scene that is read again is built otherwise");
  check_places(scene, world, ids);
  fuzz::few_steps(world, 2);
  fuzz::few_steps(world_again, 2);
  fuzz::require(world.state_hash() == world_again.state_hash(), "a scene that is read again comes to something else");
  if (scene.bodies.size() > 100) return;
  check_refused(scene);
  World measured = built(scene, ids);
  measure(scene, measured, ids, is_name(text));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    run({reinterpret_cast<const char*>(data), size});
  } catch (const Error&) {
  }
  return 0;
}

// Another value of the file's, or a name's or Wavefront file's bytes.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(text.find('\0'), size);
  const std::string changed = fuzz::mutate_json(text.substr(0, end), seed);
  const std::size_t new_size = changed.size() + (size - end);
  if (changed.empty() || new_size > max_size) return LLVMFuzzerMutate(data, size, max_size);
  std::memmove(data + changed.size(), data + end, size - end);
  std::memcpy(data, changed.data(), changed.size());
  return new_size;
}
