// Balls, rocks and solids of all kinds, dropped into a container.

#include "building_blocks.h"
#include "builtin.h"
#include "loose_solids.h"
#include "random.h"

namespace atl::scene {
namespace dropped {

constexpr double container_half = 10;  // m, of the square floor's edge

// One of all solids, 0.5 m from end to end and up to twice that, half a metre wide at least.
Shape random_solid(Random& random, int kind, const std::vector<ConvexHull>& rocks) {
  const double wide = random.uniform(0.25, 0.35), high = random.uniform(0.25, 0.5);
  switch (kind) {
    case 0:
      return Sphere{.radius = wide};
    case 1:
      return Box{.half_extents = {wide, random.uniform(0.25, 0.35), high}};
    case 2:
      return Capsule{.radius = wide, .half_height = 0.5 * high};
    case 3:
      return Cylinder{.radius = wide, .half_height = high};
    case 4:
      return Cone{.radius = wide, .half_height = high};
    default:
      return rocks[static_cast<std::size_t>(random.uniform(0, static_cast<double>(rocks.size())))];
  }
}

}  // namespace dropped

Scene build_marbles(const ParameterValues& values, std::uint64_t seed) {
  using namespace dropped;
  constexpr double drop = 0.5;      // m
  constexpr double spacing = 1.05;  // m, of a grid in which the largest have room
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

Scene build_rocks(const ParameterValues& values, std::uint64_t seed) {
  using namespace dropped;
  constexpr double radius = 0.5;  // m
  constexpr int kinds = 100;
  Scene scene = scene_on_ground(600, false);
  add_walls(scene, container_half);
  Random random(seed);
  std::vector<ConvexHull> rocks;
  for (int i = 0; i < kinds; ++i) rocks.push_back(random_rock(random, radius, 20, 40));
  const LoosePlaces places(2.1 * radius, container_half, 0.5);
  for (int i = 0; i < values.integer("bodies"); ++i) {
    const ConvexHull& rock = rocks[static_cast<std::size_t>(random.uniform(0, kinds))];
    const double off = 0.05 * radius;
    const Vector3 place = places[i] + random.in_box(Vector3::Constant(off));
    scene.bodies.push_back(loose_solid("rock_" + std::to_string(i), rock, place, random.rotation()));
  }
  return scene;
}

Scene build_mixed(const ParameterValues& values, std::uint64_t seed) {
  using namespace dropped;
  constexpr double pitch = 1.45;  // m, more than the longest across
  constexpr int kinds = 6;
  Scene scene = scene_on_ground(600, false);
  add_walls(scene, container_half);
  Random random(seed);
  std::vector<ConvexHull> rocks;
  for (int i = 0; i < 20; ++i) rocks.push_back(random_rock(random, random.uniform(0.25, 0.5), 20, 40));
  const LoosePlaces places(pitch, container_half, 0.5);
  for (int i = 0; i < values.integer("bodies"); ++i) {
    const Shape solid = random_solid(random, i % kinds, rocks);
    scene.bodies.push_back(loose_solid("solid_" + std::to_string(i), solid, places[i], random.rotation()));
  }
  return scene;
}

}  // namespace atl::scene
