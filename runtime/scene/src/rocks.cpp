#include "builtin.h"
#include "loose_solids.h"

namespace atl::scene {

Scene build_rocks(const ParameterValues& values, std::uint64_t seed) {
  constexpr double container_half = 10;  // m, of the square floor's edge
  constexpr double radius = 0.5;         // m
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

}  // namespace atl::scene
