#include "building_blocks.h"
#include "builtin.h"
#include "random.h"

namespace atl::scene {

Scene build_marbles(const ParameterValues& values, std::uint64_t seed) {
  constexpr double container_half = 10;  // m, of the square floor's edge
  constexpr double drop = 0.5;           // m
  constexpr double spacing = 1.05;       // m, of a grid in which the largest have room
  constexpr int a_row = 18;
  const Material material = {.friction = values["friction"]};
  Scene scene = scene_on_ground(600, false);
  add_walls(scene, container_half);
  for (SceneBody& body : scene.bodies) body.def.material = material;
  Random random(seed);
  const int count = values.integer("bodies");
  for (int i = 0; i < count; ++i) {
    const double radius = random.uniform(0.25, 0.5);
    const Vector3 place(i % a_row - 0.5 * (a_row - 1), i / a_row % a_row - 0.5 * (a_row - 1), i / (a_row * a_row));
    const Vector3 off = random.in_box(Vector3::Constant(0.5 * spacing - radius));
    scene.bodies.push_back({.name = "marble_" + std::to_string(i),
                            .def = {.shape = Sphere{.radius = radius},
                                    .position = spacing * place + off + Vector3(0, 0, drop + 0.5 * spacing),
                                    .density = builtin_density,
                                    .material = material}});
  }
  return scene;
}

}  // namespace atl::scene
