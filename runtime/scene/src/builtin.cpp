#include "builtin.h"

#include <charconv>
#include <cmath>

#include "analytic.h"
#include "memory_need.h"
#include "words.h"

namespace atl {
namespace scene {
namespace {

struct Entry {
  BuiltinScene scene;
  SceneBuilder build;
  /// The size of the scene. Left out if the counts among the parameters are those of bodies.
  SceneSize (*size)(const ParameterValues& values) = nullptr;
};

double pyramid_boxes(double layers) { return layers * (layers + 1) * (2 * layers + 1) / 6; }
double wall_boxes(double base) { return base * (base + 1) / 2; }

// Hulls of built-in scenes have about as many vertices.
constexpr double vertices_of_hull = 30;

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = {
      {{"pyramid3d",
        "square pyramid of unit boxes, each on the four below it",
        {{"layers", 18, 1, 300, true, "layers; the lowest has layers x layers boxes"}}},
       &build_pyramid3d,
       [](const ParameterValues& values) { return SceneSize{.bodies = pyramid_boxes(values["layers"])}; }},
      {{"wall",
        "triangular wall of unit boxes in running bond, sides touching",
        {{"base", 100, 1, 4000, true, "boxes in the lowest row; each row has one fewer"},
         {"planar", 0, 0, 1, true, "1 if boxes are locked to the plane of the wall"}}},
       &build_wall,
       [](const ParameterValues& values) { return SceneSize{.bodies = wall_boxes(values["base"])}; }},
      {{"islands",
        "many walls that never touch each other, on a square grid",
        {{"count", 400, 1, 1000000, true, "walls"}, {"base", 10, 1, 4000, true, "boxes in a wall's lowest row"}}},
       &build_islands,
       [](const ParameterValues& values) { return SceneSize{.bodies = values["count"] * wall_boxes(values["base"])}; }},
      {{"pile",
        "random boxes, half extents 0.25 to 0.75 m, dropped into a container of 20 m x 20 m",
        {{"bodies", 5000, 1, 100000, true, "boxes"}}},
       &build_pile},
      {{"marbles",
        "balls, radius 0.25 to 0.5 m, dropped into a container of 20 m x 20 m",
        {{"bodies", 5000, 1, 100000, true, "balls"}, {"friction", 0.6, 0, 2, false, "coefficient"}}},
       &build_marbles},
      {{"rocks",
        "hulls of 20 to 40 vertices, radius up to 0.5 m, dropped into a container of 20 m x 20 m",
        {{"bodies", 5000, 1, 100000, true, "hulls"}}},
       &build_rocks,
       [](const ParameterValues& values) {
         return SceneSize{.bodies = values["bodies"], .hull_vertices = vertices_of_hull * values["bodies"]};
       }},
      {{"mixed",
        "balls, boxes, capsules, cylinders, cones and hulls dropped into a container of 20 m x 20 m",
        {{"bodies", 3000, 1, 100000, true, "solids"}}},
       &build_mixed,
       [](const ParameterValues& values) {
         return SceneSize{.bodies = values["bodies"], .hull_vertices = vertices_of_hull * values["bodies"] / 6};
       }},
      {{"drum",
        "boxes in a turning drum of hulls, radius 8 m",
        {{"boxes", 3000, 1, 3200, true, "boxes"}, {"spin", 0.5, 0, 2, false, "rad/s"}}},
       &build_drum},
      {{"terrain",
        "compounds of 20 hulls that tumble over a mesh of hills",
        {{"bodies", 100, 1, 2000, true, "compounds"}, {"triangles", 100000, 128, 2000000, true, "of the mesh"}}},
       &build_terrain,
       [](const ParameterValues& values) {
         return SceneSize{.bodies = values["bodies"],
                          .hull_vertices = 20 * vertices_of_hull * values["bodies"],
                          .triangles = values["triangles"]};
       }},
      {{"hopper",
        "random boxes, half extents 0.2 to 0.4 m, that slide without friction through a funnel",
        {{"bodies", 2000, 1, 100000, true, "boxes"}, {"friction", 0, 0, 2, false, "coefficient"}}},
       &build_hopper},
      {{"stack",
        "tower of unit boxes",
        {{"height", 10, 1, 10000, true, "boxes"},
         {"ratio", 1, 1e-6, 1e6, false, "density of the top box over that of the others"}}},
       &build_stack},
      {{"conveyor",
        "boxes on a belt that drop onto one across, then onto a third, and queue up at its end",
        {{"boxes", 12, 1, 1000, true, "boxes"}, {"speed", 2, 0.1, 3, false, "m/s of the belts"}}},
       &build_conveyor},
      {{"chain",
        "chain of links with a heavy ball at its end, let go from level",
        {{"links", 100, 1, 10000, true, "links of 1 kg, 0.5 m long"},
         {"ratio", 1000, 1e-3, 1e6, false, "mass of the ball over that of a link"}}},
       &build_chain,
       [](const ParameterValues& values) { return SceneSize{.bodies = values["links"], .joints = values["links"]}; }},
      {{"joint-grid",
        "sheet of balls, each joined to its neighbours, that hangs by the middle of its upper edge",
        {{"n", 100, 2, 500, true, "balls along each edge"}}},
       &build_joint_grid,
       [](const ParameterValues& values) {
         return SceneSize{.bodies = values["n"] * values["n"], .joints = 2 * values["n"] * values["n"]};
       }},
      {{"ragdolls",
        "jointed figures of 13 parts, turned at random, dropped into a container",
        {{"count", 100, 1, 10000, true, "ragdolls"}}},
       &build_ragdolls,
       [](const ParameterValues& values) {
         return SceneSize{.bodies = 13 * values["count"], .joints = 12 * values["count"]};
       }},
      {{"bridge",
        "planks hinged to each other and to two banks, with boxes dropped on them",
        {{"planks", 40, 4, 1000, true, "planks"},
         {"ratio", 5, 0.01, 1000, false, "mass of a box over that of a plank"}}},
       &build_bridge,
       [](const ParameterValues& values) {
         return SceneSize{.bodies = 2 * values["planks"], .joints = values["planks"]};
       }},
      {{"vehicle",
        "car with suspension, steering and driven wheels on bumpy ground",
        {{"speed", 8, 0, 30, false, "m/s that the wheels are driven at"},
         {"steer", 0.1, -0.5, 0.5, false, "rad, of the front wheels to the left"}}},
       &build_vehicle},
      {{"free-flight",
        "bodies thrown over nothing: parabolas and steady spin",
        {{"speed", 10, 0, 1000, false, "m/s"}, {"spin", 6, 0, 100, false, "rad/s"}}},
       &build_free_flight},
      {{"spinning-top",
        "three boxes in free rotation, one near each principal axis; a small tilt makes the middle one flip",
        {{"spin", 4, 0.01, 100, false, "rad/s"}, {"tilt", 0.3, 1e-3, 0.7, false, "rad between the spin and the axis"}}},
       &build_spinning_top},
      {{"heavy-top",
        "symmetric top in steady precession, its ball-shaped tip sliding without friction",
        {{"precession", 2, 0.5, 10, false, "rad/s"}, {"tilt", 0.3, 0.01, 0.6, false, "rad"}}},
       &build_heavy_top},
      {{"sliding-blocks",
        "flat blocks launched outwards in all directions, until friction stops them",
        {{"headings", 360, 1, 10000, true, "blocks"},
         {"speed", 5, 0.5, 50, false, "m/s"},
         {"friction", 0.5, 0.01, 2, false, "coefficient"}}},
       &build_sliding_blocks},
      {{"incline",
        "blocks on a slope, with friction around what holds them",
        {{"angle", 0.3, 0.01, 0.8, false, "rad"}}},
       &build_incline},
      {{"tipping-block",
        "tall blocks pushed with forces around what tips them",
        {{"slenderness", 3, 2, 10, false, "height over width"}}},
       &build_tipping_block},
      {{"rolling-sphere",
        "spheres launched sliding in all directions, until friction makes them roll",
        {{"headings", 12, 1, 10000, true, "spheres"},
         {"speed", 7, 0.5, 50, false, "m/s"},
         {"friction", 0.3, 0.01, 2, false, "coefficient"}}},
       &build_rolling_sphere},
      {{"rolling-resistance",
        "spheres launched rolling in all directions, until rolling friction stops them",
        {{"headings", 12, 1, 10000, true, "spheres"},
         {"speed", 2, 0.5, 20, false, "m/s"},
         {"rolling_friction", 0.05, 0.001, 0.2, false, "m"}}},
       &build_rolling_resistance},
      {{"torsion",
        "spinning balls and a box without other friction, until torsional friction stops them",
        {{"spin", 2.5, 0.1, 20, false, "rad/s"}, {"torsional_friction", 0.01, 0.001, 0.1, false, "m"}}},
       &build_torsion},
      {{"incline-sphere",
        "spheres on a slope, with friction around what makes them roll",
        {{"angle", 0.3, 0.01, 1.2, false, "rad"}}},
       &build_incline_sphere},
      {{"pushed-box",
        "25 balls on a box that is pushed over the ground",
        {{"force", 150, 140, 300, false, "N"}, {"angle", 0.5235987755982988, 0, 6.3, false, "rad from the x axis"}}},
       &build_pushed_box},
      {{"bouncing-ball",
        "ball that loses height with each bounce",
        {{"height", 5, 1, 100, false, "m"}, {"restitution", 0.7, 0.5, 1, false, "coefficient"}}},
       &build_bouncing_ball},
      {{"elastic-ball", "ball that bounces for ever", {{"height", 2, 0.5, 100, false, "m"}}}, &build_elastic_ball},
      {{"elastic-pair",
        "pairs of spheres that collide without loss, head-on and obliquely",
        {{"speed", 2, 0.1, 100, false, "m/s"},
         {"ratio", 3, 1, 1000, false, "mass of the heavier sphere over that of the lighter"},
         {"offset", 0.5, 0.01, 0.9, false, "of the oblique pairs' centres, over the sum of the radii"}}},
       &build_elastic_pair},
      {{"stack-forces",
        "tower of unit boxes: contact forces against the weight above",
        {{"height", 10, 1, 1000, true, "boxes"},
         {"ratio", 1, 1e-3, 1e3, false, "density of the top box over that of the others"}}},
       &build_stack_forces},
      {{"rocking-block",
        "slender block, released on edge, that rocks",
        {{"slenderness", 4, 2, 10, false, "height over width"},
         {"release", 0.6, 0.1, 0.9, false, "tilt at the start over that of balance"}}},
       &build_rocking_block},
      {{"cradle",
        "row of spheres, a little apart, that is hit by one more",
        {{"count", 5, 1, 100, true, "spheres in the row"},
         {"speed", 2, 0.1, 100, false, "m/s"},
         {"gap", 0.01, 1e-6, 0.1, false, "m between neighbours"}}},
       &build_cradle},
      {{"pendulum",
        "rod that swings on a hinge",
        {{"angle", 2, 0.01, 3.1, false, "rad from hanging down, at release"}}},
       &build_pendulum},
      {{"double-pendulum",
        "two rods, one hinged to the end of the other, that swing",
        {{"angle", 1.5, 0.01, 2, false, "rad from hanging down, at release"}}},
       &build_double_pendulum},
      {{"slider-crank",
        "crank, turned by a motor, that moves a slider by a rod",
        {{"speed", 5, 0.5, 50, false, "rad/s of the crank"}, {"rod", 3, 1.1, 20, false, "length over the crank's"}}},
       &build_slider_crank},
      {{"spring-damper",
        "weights on springs with no, little, critical and strong damping",
        {{"hertz", 1, 0.2, 10, false, "Hz"}}},
       &build_spring_damper},
      {{"hanging-chain",
        "chain that hangs straight down under a weight",
        {{"links", 20, 1, 10000, true, "links of 1 kg, 0.5 m long"},
         {"ratio", 100, 1e-3, 1e6, false, "mass of the weight over that of a link"}}},
       &build_hanging_chain,
       [](const ParameterValues& values) { return SceneSize{.bodies = values["links"], .joints = values["links"]}; }},
      {{"catenary",
        "chain that hangs between two supports",
        {{"links", 40, 2, 10000, true, "links of 1 kg, 0.5 m long"},
         {"slack", 1.3, 1.01, 5, false, "length of the chain over its span"}}},
       &build_catenary,
       [](const ParameterValues& values) { return SceneSize{.bodies = values["links"], .joints = values["links"]}; }},
  };
  return all;
}

std::vector<std::string_view> scene_names() {
  std::vector<std::string_view> names;
  for (const Entry& entry : entries()) names.push_back(entry.scene.name);
  return names;
}

const Entry& find_entry(std::string_view name) {
  for (const Entry& entry : entries()) {
    if (entry.scene.name == name) return entry;
  }
  throw SceneError("unknown scene " + quote(name) + ": expected " + listed(scene_names()) +
                   ", or a scene file ending in .json" + suggestion(name, scene_names()));
}

std::string range_words(const SceneParameter& parameter) {
  return (parameter.integer ? "an integer in [" : "a number in [") + number_text(parameter.min) + ", " +
         number_text(parameter.max) + "]";
}

SceneSize size_of(const Entry& entry, const ParameterValues& values) {
  if (entry.size != nullptr) return entry.size(values);
  SceneSize size;
  for (const SceneParameter& parameter : entry.scene.parameters) {
    if (parameter.integer) size.bodies += values[parameter.name];
  }
  return size;
}

// For a count above its range: throws SceneTooLarge if a scene of that size needs more than there is.
void check_memory_of(const Entry& entry, ParameterValues values, const SceneParameter& parameter, double value,
                     const std::string& message) {
  if (!parameter.integer || !(value > parameter.max) || !std::isfinite(value)) return;
  values.set(parameter.name, value);
  const std::string words = memory_words(size_of(entry, values));
  if (!words.empty()) throw SceneTooLarge(message + "; it would need " + words);
}

double read_value(const Entry& entry, const ParameterValues& values, const SceneParameter& parameter,
                  std::string_view text) {
  const BuiltinScene& scene = entry.scene;
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size() && !text.empty();
  const bool is_kind = whole && !(parameter.integer && std::trunc(value) != value);
  if (!is_kind || !(value >= parameter.min && value <= parameter.max)) {
    const char* why = !is_kind                ? ""
                      : value < parameter.min ? ", too small"
                      : value > parameter.max ? ", too large"
                                              : "";
    const std::string message =
        scene.name + ": " + parameter.name + ": found " + quote(text) + why + ", expected " + range_words(parameter);
    if (is_kind) check_memory_of(entry, values, parameter, value, message);
    throw SceneError(message);
  }
  return value;
}

const SceneParameter& find_parameter(const BuiltinScene& scene, std::string_view name) {
  std::vector<std::string_view> names;
  for (const SceneParameter& parameter : scene.parameters) {
    if (parameter.name == name) return parameter;
    names.push_back(parameter.name);
  }
  throw SceneError(scene.name + ": unknown parameter " + quote(name) + ": expected " + listed(names) +
                   suggestion(name, names));
}

// "param=value,param=value".
void read_values(const Entry& entry, std::string_view text, ParameterValues& values) {
  const BuiltinScene& scene = entry.scene;
  std::vector<std::string_view> given;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    more = comma != std::string_view::npos;
    if (more) text.remove_prefix(comma + 1);

    const std::size_t equals = item.find('=');
    if (equals == std::string_view::npos) {
      throw SceneError(scene.name + ": found " + quote(item) + ", expected parameter=value after the colon");
    }
    const SceneParameter& parameter = find_parameter(scene, item.substr(0, equals));
    for (const std::string_view name : given) {
      if (name == parameter.name) throw SceneError(scene.name + ": parameter " + quote(name) + " is given twice");
    }
    given.push_back(parameter.name);
    values.set(parameter.name, read_value(entry, values, parameter, item.substr(equals + 1)));
  }
}

}  // namespace

ParameterValues::ParameterValues(const BuiltinScene& scene) : scene_(&scene) {
  for (const SceneParameter& parameter : scene.parameters) values_.push_back(parameter.value);
}

std::size_t ParameterValues::index(std::string_view name) const {
  std::size_t i = 0;
  while (scene_->parameters.at(i).name != name) ++i;
  return i;
}

std::string ParameterValues::address() const {
  std::string address = scene_->name;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    address += (i == 0 ? ":" : ",") + scene_->parameters[i].name + "=" + number_text(values_[i]);
  }
  return address;
}

Scene load_builtin(std::string_view text, std::uint64_t seed) {
  const std::size_t colon = text.find(':');
  const Entry& entry = find_entry(text.substr(0, colon));
  ParameterValues values(entry.scene);
  if (colon != std::string_view::npos) read_values(entry, text.substr(colon + 1), values);
  if (const std::string words = memory_words(size_of(entry, values)); !words.empty()) {
    throw SceneTooLarge(values.address() + ": needs " + words);
  }
  Scene scene = entry.build(values, seed);
  scene.name = values.address();
  return scene;
}

}  // namespace scene

const std::vector<BuiltinScene>& builtin_scenes() {
  static const std::vector<BuiltinScene> all = [] {
    std::vector<BuiltinScene> scenes;
    for (const scene::Entry& entry : scene::entries()) scenes.push_back(entry.scene);
    return scenes;
  }();
  return all;
}

}  // namespace atl
