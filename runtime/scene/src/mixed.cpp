#include "builtin.h"
#include "loose_solids.h"

namespace atl::scene {
namespace mixed {

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

}  // namespace mixed

Scene build_mixed(const ParameterValues& values, std::uint64_t seed) {
  constexpr double container_half = 10;  // m, of the square floor's edge
  constexpr double pitch = 1.45;         // m, more than the longest across
  constexpr int kinds = 6;
  Scene scene = scene_on_ground(600, false);
  add_walls(scene, container_half);
  Random random(seed);
  std::vector<ConvexHull> rocks;
  for (int i = 0; i < 20; ++i) rocks.push_back(random_rock(random, random.uniform(0.25, 0.5), 20, 40));
  const LoosePlaces places(pitch, container_half, 0.5);
  for (int i = 0; i < values.integer("bodies"); ++i) {
    const Shape solid = mixed::random_solid(random, i % kinds, rocks);
    scene.bodies.push_back(loose_solid("solid_" + std::to_string(i), solid, places[i], random.rotation()));
  }
  return scene;
}

}  // namespace atl::scene
