#pragma once

#include <atoll/scene.h>

#include <string>

#include "lattice.h"

namespace atl::scene {

/// Material and density of all built-in scenes.
inline constexpr Material builtin_material = {.friction = 0.6, .restitution = 0};
inline constexpr double builtin_density = 1000;  // kg/m^3

/// A static half-space.
inline SceneBody solid_beyond(std::string name, const Vector3& normal, double offset) {
  return {.name = std::move(name),
          .def = {.type = BodyType::Static,
                  .shape = HalfSpace{.normal = normal, .offset = offset},
                  .material = builtin_material}};
}

inline SceneBody ground() { return solid_beyond("ground", {0, 0, 1}, 0); }

/// A scene with nothing but the ground.
inline Scene scene_on_ground(int steps, bool starts_at_rest) {
  Scene scene;
  scene.steps = steps;
  scene.starts_at_rest = starts_at_rest;
  scene.bodies.push_back(ground());
  return scene;
}

/// Walls without a top around a square floor, `half` metres from its middle.
inline void add_walls(Scene& scene, double half) {
  scene.bodies.push_back(solid_beyond("wall_west", {1, 0, 0}, -half));
  scene.bodies.push_back(solid_beyond("wall_east", {-1, 0, 0}, -half));
  scene.bodies.push_back(solid_beyond("wall_south", {0, 1, 0}, -half));
  scene.bodies.push_back(solid_beyond("wall_north", {0, -1, 0}, -half));
}

/// A cube of 1 m edge.
inline SceneBody unit_box(std::size_t number, const Vector3& position) {
  return {.name = "box_" + std::to_string(number),
          .def = {.shape = Box{.half_extents = {0.5, 0.5, 0.5}},
                  .position = position,
                  .density = builtin_density,
                  .material = builtin_material}};
}

/// Adds unit boxes on a lattice, the lowest standing on the plane z = 0 around `centre`.
inline void add_unit_boxes(Scene& scene, const Lattice& lattice, const Vector3& centre = Vector3::Zero()) {
  std::size_t number = scene.bodies.size() - 1;  // the ground is not a box
  for (const Vector3& point : lattice.points()) {
    scene.bodies.push_back(unit_box(number++, centre + point + Vector3(0, 0, 0.5)));
  }
}

/// A wall of running bond, one box deep: `base` boxes below, one fewer each row.
inline Lattice wall_lattice(int base) { return {.count = {base, 1, base}, .taper = {1, 0}}; }

}  // namespace atl::scene
