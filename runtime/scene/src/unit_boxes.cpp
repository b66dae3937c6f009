// Unit boxes that stand on the ground.

#include <cmath>

#include "building_blocks.h"
#include "builtin.h"
#include "max_parts.h"
#include "words.h"

namespace atl::scene {

Scene build_stack(const ParameterValues& values, std::uint64_t) {
  Scene scene = scene_on_ground(600, true);
  add_unit_boxes(scene, {.count = {1, 1, values.integer("height")}});
  scene.bodies.back().def.density *= values["ratio"];
  return scene;
}

Scene build_wall(const ParameterValues& values, std::uint64_t) {
  Scene scene = scene_on_ground(200, true);
  add_unit_boxes(scene, wall_lattice(values.integer("base")));
  if (values.integer("planar") == 1) {
    for (SceneBody& body : scene.bodies) body.def.locks = MotionLocks::plane(Axis::Y);
  }
  return scene;
}

Scene build_pyramid3d(const ParameterValues& values, std::uint64_t) {
  const int layers = values.integer("layers");
  Scene scene = scene_on_ground(300, true);
  // Neighbours in a layer don't touch: each box stands on the four below it and nothing else.
  add_unit_boxes(scene, {.count = {layers, layers, layers}, .spacing = {1.02, 1.02, 1}, .taper = {1, 1}});
  return scene;
}

Scene build_islands(const ParameterValues& values, std::uint64_t) {
  const int count = values.integer("count"), base = values.integer("base");
  const Lattice wall = wall_lattice(base);
  if (count * wall.size() >= static_cast<double>(max_bodies)) {
    throw SceneError(values.address() + ": found " + number_text(count * wall.size()) + " boxes, expected fewer than " +
                     std::to_string(max_bodies));
  }
  // A wall is as wide as its base, so 2 m are left between walls in a row and more between the rows.
  const double pitch = base + 2;
  const int side = static_cast<int>(std::ceil(std::sqrt(count)));
  std::vector<Vector3> centres = Lattice{.count = {side, side, 1}, .spacing = {pitch, pitch, 1}}.points();
  centres.resize(static_cast<std::size_t>(count));

  Scene scene = scene_on_ground(100, true);
  for (const Vector3& centre : centres) add_unit_boxes(scene, wall, centre);
  return scene;
}

}  // namespace atl::scene
