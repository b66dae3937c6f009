#pragma once
/// Building blocks of the scenes of several cases. The start of a scene uses no function of the C library except the
/// square root, so it is the same on every machine.

#include <numbers>
#include <string>

#include "scene/src/analytic/setting.h"
#include "scene/src/words.h"

namespace atl::stability {

using scene::ground;
using scene::numbered;
using scene::plane;
using scene::solid;
using scene::turned;

inline constexpr double standard_gravity = scene::standard_gravity;  // m/s^2
inline constexpr double degree = std::numbers::pi / 180;             // rad

inline double substep(const Scene& scene) { return scene.dt / scene.settings.substeps; }

inline Vector3 corner(double edge) { return Vector3::Constant(edge / 2); }

/// Adds cubes one upon the other; the lowest stands at `base`.
inline void add_tower(Scene& scene, int height, double edge = 1, const Vector3& base = Vector3::Zero(),
                      const Material& material = scene::builtin_material) {
  for (int i = 0; i < height; ++i) {
    const auto number = static_cast<int>(scene.bodies.size());
    scene.bodies.push_back(
        solid(numbered("box", number), Box{corner(edge)}, base + Vector3(0, 0, (i + 0.5) * edge), material));
  }
}

/// A tower on the ground.
inline Scene tower(int height, double edge = 1, const Material& material = scene::builtin_material) {
  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies.push_back(plane(material));
  add_tower(scene, height, edge, Vector3::Zero(), material);
  return scene;
}

inline SceneBody fixed_box(std::string name, const Vector3& half_extents, const Vector3& position,
                           const Material& material = scene::builtin_material) {
  SceneBody body = solid(std::move(name), Box{half_extents}, position, material);
  body.def.type = BodyType::Static;
  return body;
}

inline SceneBody kinematic_box(std::string name, const Vector3& half_extents, const Vector3& position,
                               const Vector3& velocity) {
  SceneBody body = solid(std::move(name), Box{half_extents}, position, scene::builtin_material);
  body.def.type = BodyType::Kinematic;
  body.def.velocity = velocity;
  return body;
}

/// A number as it stands in a case's name: "1e-6", "0.01", "1000".
inline std::string in_name(double number) {
  std::string text = scene::number_text(number);
  std::erase(text, '+');
  return text;
}

}  // namespace atl::stability
