#pragma once
/// Building blocks of the scenes with joints.

#include <cmath>
#include <string>
#include <utility>

#include "joining.h"

namespace atl::scene {

inline constexpr double chain_link_length = 0.5;  // m
inline constexpr double chain_link_radius = 0.1;  // m
inline constexpr double chain_link_mass = 1;      // kg

/// A body of a scene in which no bodies collide.
inline SceneBody untouched(SceneBody body) {
  body.def.filter.group = -1;
  return body;
}

inline SceneBody fixed_ball(std::string name, const Vector3& centre, double radius) {
  SceneBody body;
  body.name = std::move(name);
  body.def = {.type = BodyType::Static, .shape = Sphere{radius}, .position = centre};
  return body;
}

/// A capsule of 1 kg from end to end, which touches nothing; its z axis points along a unit vector.
inline SceneBody chain_link(int number, const Vector3& centre, const Vector3& along) {
  SceneBody body;
  body.name = "link_" + std::to_string(number);
  // A third of a turn about (1, 1, 1) takes the shape's z axis to the frame's x axis.
  const Quaternion cycle(0.5, 0.5, 0.5, 0.5);
  body.def = {.shape = Capsule{.radius = chain_link_radius, .half_height = chain_link_length / 2 - chain_link_radius},
              .position = centre,
              .orientation = (frame_along(along) * cycle).normalized(),
              .mass = chain_link_mass};
  return untouched(body);
}

/// Joins the last body to the one before it at a place in the world, with frames along the world's axes.
inline void join_last_two(Scene& scene, const JointKind& kind, const Vector3& at,
                          const Quaternion& axes = Quaternion::Identity()) {
  const std::size_t last = scene.bodies.size() - 1;
  scene.joints.push_back(
      joined(scene, "joint_" + std::to_string(scene.joints.size()), kind, last - 1, last, {at, axes}));
}

}  // namespace atl::scene
