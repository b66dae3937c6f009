#include <atoll/scene.h>

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "finding.h"
#include "seeds.h"
#include "small_scenes.h"

namespace atl::fuzz::seeds {
namespace {

std::string scene_file(const std::string& keys) { return R"({"format": "atoll-scene", "version": 1, )" + keys + "}"; }

// Throws SceneError if it is not.
void write_valid(const fs::path& path, const std::string& file) {
  parse_scene(file, path.filename().string());
  write(path, text(file));
}

// Small files that have all keys between them, each with two bodies to be joined.
void write_small_files(const fs::path& folder) {
  const std::string axis =
      R"({"range": [-1, 1], "restitution": 0.1, "spring": {"hertz": 2, "damping_ratio": 1, "rest": 0}, "armature": 0.1})";
  const std::string driven =
      R"({"lower": 0.5, "spring": {"stiffness": 9, "damping": 1}, "motor": {"speed": 1, "max_force": "unlimited",
          "servo": {"target": 0.1, "stiffness": 9, "damping": 1}}})";
  const std::string limited = R"({"upper": 1, "motor": {"max_force": 5}})";
  const std::string three = "[" + axis + ", " + driven + ", " + limited + "]";
  const std::string two =
      R"({"name": "a", "type": "static", "shape": {"type": "half_space", "normal": [0, 0, 1], "offset": -2}},
    {"name": "b", "shape": {"type": "sphere", "radius": 0.5}, "position": [0, 0, 1]})";
  const std::vector<std::pair<std::string, std::string>> joints = {
      {"ball", R"("at": [0, 0, 1], "friction": 1)"},
      {"hinge",
       R"("at": [0, 0, 1], "axis": [0, 1, 0], "collide": true, "break_force": 9, "break_torque": 9, "angle": )" + axis},
      {"slider", R"("at": [0, 0, 1], "user_data": "9007199254740993", "offset": )" + driven},
      {"fixed", R"("frame_first": {"position": [0, 0, 1], "orientation": [0, 0, 0, 1]}, "frame_second": {})"},
      {"distance", R"("at": [0, 0, 0], "at_second": [0, 0, 1], "distance": )" + limited},
      {"universal",
       R"("at": [0, 0, 1], "across": [0, 1, 0], "angle_first": )" + axis + R"(, "angle_second": )" + driven},
      {"cone_twist", R"("at": [0, 0, 1], "swing_limit": 1, "swing_friction": 1, "twist": )" + axis},
      {"six_dof", R"("at": [0, 0, 1], "offset": )" + three + R"(, "turn": )" + three},
      {"gear", R"("axis": [0, 0, 1], "axis_second": [0, 1, 0], "ratio": 2, "rack": true)"},
      {"wheel",
       R"("at": [0, 0, 1], "suspension": )" + axis + R"(, "steering": )" + limited + R"(, "spin": )" + driven}};
  for (const auto& [kind, keys] : joints) {
    const std::string joint = R"({"name": "j", "kind": ")" + kind + R"(", "first": "a", "second": 1, )" + keys + "}";
    write_valid(folder / ("small-" + kind), scene_file("\"bodies\": [" + two + "], \"joints\": [" + joint + "]"));
  }
  const std::vector<std::pair<std::string, std::string>> others = {
      {"keys", R"("name": "s", "description": "all of it", "gravity": [0, 0, -9], "dt": 0.01, "steps": 9,
        "starts_at_rest": true, "bodies": [)" +
                   two + "]"},
      {"settings", R"("settings": {"substeps": 2, "iterations": 2, "relax_iterations": 1, "tolerance": 0.1,
        "friction": "pyramid", "warm_starting": false, "stabilisation": "split_impulse", "correction": 0.3,
        "slop": 0.001, "contact_hertz": 20, "contact_damping_ratio": 5, "contact_push_speed": 2,
        "restitution_threshold": 1, "contact_solver": "direct", "joint_solver": "iterative", "joint_hertz": 30,
        "joint_damping_ratio": 1, "sleeping": true, "sleep_speed": 0.1, "time_to_sleep": 0.1}, "bodies": [)" +
                       two + "]"},
      {"target", R"("settings": {"target": {"penetration": 0.001, "joint_gap": 0.001, "residual": 0.01, "motion": 0.001,
        "min_substeps": 2, "max_substeps": 16}}, "bodies": [)" +
                     two + "]"},
      {"library", R"("materials": {"m": {"friction": 1, "restitution": 0.5, "rolling_friction": 0.1,
        "torsional_friction": 0.1}}, "shapes": {"s": {"type": "cone", "radius": 1, "half_height": 1}},
        "bodies": [{"shape": "s", "material": "m"}])"},
      {"body", R"("bodies": [{"name": "n", "type": "dynamic", "shape": {"type": "box", "half_extents": [1, 2, 3]},
        "position": [1, 2, 3], "orientation": [0, 0, 1, 1], "velocity": [1, 0, 0], "angular_velocity": [0, 1, 0],
        "surface_velocity": [1, 1, 0], "surface_angular_velocity": [0, 0, 1],
        "mass": 9, "inertia": [9, 8, 7, 1, 0, 0], "gravity_scale": 0.5,
        "linear_damping": 0.1, "angular_damping": 0.2, "locks": {"linear": ["x"], "angular": ["y", "z"]},
        "force": [1, 0, 0], "filter": {"category": 2, "mask": 3, "group": -1}, "continuous": true, "sensor": false,
        "user_data": 7}])"},
      {"plane", R"("bodies": [{"shape": {"type": "capsule", "radius": 1, "half_height": 1}, "density": 5,
        "locks": {"plane": "y"}}, {"type": "kinematic", "sensor": true, "shape": {"type": "cylinder", "radius": 1,
        "half_height": 1}, "velocity": [0, 0, 1]}])"},
      {"generator", R"("generators": [{"body": {"name": "g", "shape": {"type": "sphere", "radius": 0.4}},
        "count": [3, 2, 2], "spacing": [1, 1, 1], "taper": [1, 0], "stagger": [0.5, 0], "jitter": [0.1, 0, 0],
        "random_orientation": true, "copies": {"count": [2, 1, 1], "spacing": [9, 1, 1]}}])"},
      {"hull", R"("bodies": [{"shape": {"type": "hull", "scale": [1, 1, -2],
        "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}}])"},
      {"mesh", R"("bodies": [{"type": "static", "shape": {"type": "mesh", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
        "triangles": [[0, 1, 2]], "smooth_angle": 0.5, "scale": [1, 2, 1]}}])"},
      {"height-field", R"("bodies": [{"type": "static", "shape": {"type": "height_field", "heights": [[0, 1], [1, 0]],
        "spacing": [1, 2], "smooth": true}}])"},
      {"compound", R"("bodies": [{"shape": {"type": "compound", "children": [{"shape": {"type": "sphere", "radius": 1},
        "position": [1, 0, 0], "orientation": [0, 0, 0, 1], "density_factor": 2, "material": {"friction": 0.1},
        "filter": {"mask": 1}}]}}])"}};
  for (const auto& [name, keys] : others) write_valid(folder / ("small-" + name), scene_file(keys));
  write(folder / "odd-key", text(scene_file(R"("a~b/c\u0001": 1)")));
  write(folder / "deep", text(scene_file("\"bodies\": " + std::string(70, '[') + std::string(70, ']'))));
}

// Each wrong in one place.
void write_wrong_files(const fs::path& folder) {
  const std::string bodies = R"("bodies": [{"name": "a", "shape": {"type": "sphere", "radius": 0.5}},
    {"name": "b", "type": "static", "shape": {"type": "half_space"}, "position": [0, 0, -1]},
    {"type": "static", "shape": {"type": "half_space"}, "position": [0, 0, -2]}])";
  const std::vector<std::string> joints = {
      R"("kind": "hinge", "first": "a", "second": "b", "at": [0, 0, 0], "angle": {"range": [1, -1]})",
      R"("kind": "hinge", "first": "a", "second": "b", "at": [0, 0, 0], "angle": {"lower": 1, "upper": 0})",
      R"("kind": "hinge", "first": "a", "second": "b", "at": [0, 0, 0], "axis": [0, 0, 0])",
      R"("kind": "hinge", "first": "a", "second": "b", "at": [0, 0, 0],
         "angle": {"motor": {"max_force": 1, "servo": {}}})",
      R"("kind": "universal", "first": "a", "second": "b", "at": [0, 0, 0], "axis": [0, 1, 0], "across": [0, 2, 0])",
      R"("kind": "distance", "first": "a", "second": "b", "at": [0, 0, 0], "at_second": [0, 0, 0])",
      R"("kind": "ball", "first": "a", "second": "bb", "at": [0, 0, 0])",
      R"("name": "j", "kind": "ball", "first": "a", "second": "b", "at": [0, 0, 0]}, {"name": "j", "kind": "ball",
         "first": "a", "second": 2, "at": [0, 0, 0])"};
  const std::string ball = R"("shape": {"type": "sphere", "radius": 0.5})";
  const std::vector<std::string> others = {
      R"("bodies": [{"mass": 1, "inertia": [1, 1, 9], )" + ball + "}]",
      R"("bodies": [{"mass": 1, "inertia": [1, 1, -1], )" + ball + "}]",
      R"("bodies": [{"type": "static", "density": 1, )" + ball + "}]",
      R"("bodies": [{"type": "static", "velocity": [1, 0, 0], )" + ball + "}]",
      R"("bodies": [{"orientation": [0, 0, 0, 0], )" + ball + "}]",
      R"("bodies": [{"locks": {"linear": ["x"], "plane": "y"}, )" + ball + "}]",
      R"("bodies": [{"type": "static", "sensor": true, "shape": {"type": "half_space"}}])",
      R"("bodies": [{"shape": {"type": "half_space", "normal": [0, 0, 0]}}])",
      R"("bodies": [{"type": "static", "shape": {"type": "mesh", "file": "none.obj", "triangles": []}}])",
      R"("bodies": [{"type": "static", "shape": {"type": "mesh", "file": "none.obj"}}])",
      R"("generators": [{"count": [1, 1, 1], "random_orientation": true, "body": {"orientation": [0, 0, 0, 1], )" +
          ball + "}}]",
      R"("generators": [{"count": [9, 1, 1], "spacing": [1e308, 0, 0], "body": {"position": [1e308, 0, 0], )" + ball +
          "}}]",
      R"("settings": {"target": {"min_substeps": 9, "max_substeps": 8, "motion": 1}})",
      R"("settings": {"target": {"motion": 1}, "stabilisation": "baumgarte"})",
      R"("settings": {"target": {"penetration": 1}, "contact_hertz": 9})",
      R"("settings": {"target": {"joint_gap": 1}, "joint_hertz": 9})",
      R"("generators": [{"count": [4000, 4000, 1], "body": {)" + ball + "}}]"};
  int number = 0;
  const auto write_wrong = [&](const std::string& keys) {
    const std::string file = scene_file(keys);
    require_refused(file, [&] { parse_scene(file, "wrong"); });
    write(folder / ("wrong-" + std::to_string(number++)), text(file));
  };
  for (const std::string& joint : joints) write_wrong(bodies + ", \"joints\": [{" + joint + "}]");
  for (const std::string& keys : others) write_wrong(keys);
}

}  // namespace

void write_scenes(const fs::path& folder, std::span<char*> files) {
  for (const char* name : small_scenes) write(folder / plain(name), text(scene_text(load_scene(name))));
  for (const BuiltinScene& scene : builtin_scenes()) {
    // All parameters, and the least of each that is a count.
    std::string name = scene.name;
    for (const SceneParameter& parameter : scene.parameters) {
      std::ostringstream value;
      value << (parameter.integer ? parameter.min : parameter.value);
      name += (name == scene.name ? ":" : ",") + parameter.name + "=" + value.str();
    }
    write(folder / ("named-" + scene.name), text(name));
  }
  write_small_files(folder);
  write_wrong_files(folder);
  int number = 0;
  for (const char* wrong :
       {"piel:bodies=1", "a scene", "stack:hight=2", "stack:height", "stack:height=0", "stack:height=2.5",
        "stack:height=1,height=1", "pile:bodies=1e9", "pile:bodies=1e300", "marbles:bodies=1,friction=nan"}) {
    write(folder / ("wrong-name-" + std::to_string(number++)), text(wrong));
  }
  write(folder / "named-planar-wall", text("wall:base=2,planar=1"));
  const auto write_wavefront = [&](const char* name, const char* type, const std::string& file) {
    const std::string shape = std::string("{\"type\": \"") + type + "\", \"file\": \"mesh.obj\", \"scale\": [1, 2, 1]}";
    write(folder / (std::string("wavefront-") + name),
          text(scene_file("\"bodies\": [{\"type\": \"static\", \"shape\": " + shape + "}]") + '\0' + file));
  };
  const std::string mesh =
      "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0.5\nv 1 1 1\nf 1 2 3\nf 1/1 3/3 4/4\nf 1 2 5 # a comment\n";
  write_wavefront("mesh", "mesh", mesh);
  write_wavefront("hull", "hull", mesh);
  write_wavefront("word", "mesh", "v 0 0 zero\n");
  write_wavefront("beyond", "mesh", mesh + "f 1 2 6\n");
  write_wavefront("edge", "mesh", mesh + "f 1 2\n");
  write_wavefront("empty", "mesh", "\n");
  for (const char* file : files) write(folder / fs::path(file).filename(), read(file));
}

}  // namespace atl::fuzz::seeds
