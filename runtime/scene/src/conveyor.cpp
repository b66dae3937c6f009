// Boxes ride on a belt, drop onto one across, then onto a third, and queue up at its end.

#include <numbers>

#include "analytic/setting.h"
#include "builtin.h"

namespace atl::scene {
namespace conveyor {

constexpr double half_width = 1;  // m, of a belt
constexpr double half_thickness = 0.2;
constexpr double top = 0.5;    // m, of the last belt
constexpr double drop = 0.1;   // m, from belt to belt: flush ones would have their edges felt
constexpr double pitch = 2.5;  // m, between boxes at the start
constexpr double across = 6;   // m, length of the middle belt

/// A belt that runs along its own x axis, which points `quarters` quarter turns from the world's.
SceneBody belt(int number, const Vector3& start, int quarters, double length, double speed) {
  const Vector3 directions[] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  SceneBody body;
  body.name = numbered("belt", number);
  body.def = {.type = BodyType::Static,
              .shape = Box{{length / 2, half_width, half_thickness}},
              .position = start + length / 2 * directions[quarters] - Vector3(0, 0, half_thickness),
              .orientation = turned(quarters * std::numbers::pi / 2, Vector3::UnitZ()),
              .material = builtin_material,
              .surface_velocity = {speed, 0, 0}};
  return body;
}

}  // namespace conveyor

Scene build_conveyor(const ParameterValues& values, std::uint64_t) {
  using namespace conveyor;
  const int boxes = values.integer("boxes");
  const double speed = values["speed"];
  const double first = pitch * boxes, last = boxes + 3.0;
  Scene scene = scene_on_ground(600, false);
  // Each belt starts under the middle of the one before it, as seen along that one, and a drop below.
  scene.bodies.push_back(belt(0, {-first, 0, top + 2 * drop}, 0, first, speed));
  scene.bodies.push_back(belt(1, {half_width, -half_width, top + drop}, 1, across, speed));
  scene.bodies.push_back(belt(2, {2 * half_width, across, top}, 2, last, speed));
  SceneBody stop;
  stop.name = "stop";
  stop.def = {.type = BodyType::Static,
              .shape = Box{{half_thickness, half_width, 0.5}},
              .position = {2 * half_width - last + half_thickness, across, top + 0.5},
              .material = builtin_material};
  scene.bodies.push_back(stop);
  for (int i = 0; i < boxes; ++i) {
    const Vector3 position(-pitch * (i + 0.5), 0, top + 2 * drop + 0.5);
    scene.bodies.push_back(unit_box(static_cast<std::size_t>(i), position));
  }
  return scene;
}

}  // namespace atl::scene
