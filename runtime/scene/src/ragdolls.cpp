// Ragdolls that fall into a container, turned at random, and come to rest in a heap.

#include <cmath>

#include "building_blocks.h"
#include "builtin.h"
#include "lattice.h"
#include "ragdoll.h"
#include "random.h"

namespace atl::scene {

Scene build_ragdolls(const ParameterValues& values, std::uint64_t seed) {
  const int count = values.integer("count");
  constexpr double pitch = 2 * ragdoll_reach + 0.02;  // m: no turn makes neighbours touch
  // Layers of a square, wider than high.
  int side = 1;
  while (side * side * (side + 1) / 2 < count) ++side;
  std::vector<Vector3> places =
      Lattice{.count = {side, side, (side + 1) / 2 + 1}, .spacing = Vector3::Constant(pitch)}.points();
  places.resize(static_cast<std::size_t>(count));

  Scene scene = scene_on_ground(600, false);
  scene.settings.sleeping = true;
  const double half = side * pitch / 2;
  add_walls(scene, half);
  Random random(seed);
  for (int i = 0; i < count; ++i) {
    const Vector3 centre = places[static_cast<std::size_t>(i)] + Vector3(0, 0, 1.5 * pitch / 2);
    add_ragdoll(scene, i, {centre, random.rotation()});
  }
  return scene;
}

}  // namespace atl::scene
