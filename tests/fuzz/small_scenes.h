#pragma once
/// Scenes of few bodies which have all kinds of shapes and joints between them, after some steps.

#include <atoll/atoll.h>

#include <array>
#include <cstddef>

namespace atl::fuzz {

inline constexpr std::array small_scenes = {
    "stack:height=3", "mixed:bodies=8", "ragdolls:count=1", "terrain:bodies=1,triangles=128",
    "vehicle",        "chain:links=4",  "bridge:planks=4",  "conveyor:boxes=2",
    "torsion",        "pile:bodies=6"};

inline World small_world(std::size_t number, int steps) {
  const Scene scene = load_scene(small_scenes[number % small_scenes.size()]);
  World world({.gravity = scene.gravity, .settings = scene.settings});
  const std::vector<BodyId> ids = build_scene(scene, world);
  for (int i = 0; i < steps; ++i) {
    apply_forces(scene, world, ids);
    world.step(scene.dt);
  }
  return world;
}

}  // namespace atl::fuzz
