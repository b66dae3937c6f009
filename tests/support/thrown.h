#pragma once
/// Assemblies of joined bodies, thrown at a wall that stands across the x axis at x = 0.

#include <atoll/atoll.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "support/bodies.h"
#include "support/min_turn.h"

namespace atl::test {

/// The i-th of numbers in [0, 1) that fill it evenly, whatever their count.
inline double spread(int i, double ratio = 0.618033988749895) { return std::fmod(ratio * i, 1.0); }

inline Scene before_a_wall(double thickness) {
  Scene scene;
  scene.gravity.setZero();
  scene.bodies.push_back({.name = "wall", .def = static_box({0, 0, 0}, {thickness / 2, 500, 500})});
  return scene;
}

inline std::size_t add(Scene& scene, const BodyDef& def) {
  scene.bodies.push_back({.name = "body_" + std::to_string(scene.bodies.size()), .def = def});
  return scene.bodies.size() - 1;
}

/// Joins two bodies of a scene at a point of the world, with frames along its axes.
inline void join(Scene& scene, const JointKind& kind, std::size_t first, std::size_t second, const Vector3& point) {
  const auto seen_from = [&](const BodyDef& body) -> Pose {
    return {body.orientation.conjugate() * (point - body.position), body.orientation.conjugate()};
  };
  SceneJoint joint{.name = "joint_" + std::to_string(scene.joints.size()), .first = first, .second = second};
  joint.def.kind = kind;
  joint.def.frame_first = seen_from(scene.bodies[first].def);
  joint.def.frame_second = seen_from(scene.bodies[second].def);
  scene.joints.push_back(joint);
}

/// Two balls of a radius of 0.1 m at a distance of 0.5 m.
inline void throw_pair(Scene& scene, const JointKind& kind, const Vector3& middle, const Quaternion& turn,
                       const Vector3& velocity) {
  for (const double side : {-0.25, 0.25}) {
    BodyDef ball = sphere(middle + turn * Vector3(side, 0, 0), 0.1);
    ball.velocity = velocity;
    add(scene, ball);
  }
  const std::size_t last = scene.bodies.size() - 1;
  join(scene, kind, last - 1, last, middle);
  if (!std::holds_alternative<DistanceJoint>(kind)) return;
  scene.joints.back().def.frame_first = scene.joints.back().def.frame_second = {};
}

/// Links of 0.2 m on ball joints, from a point on.
inline void throw_chain(Scene& scene, const Vector3& from, const Vector3& along, int links, const Vector3& velocity) {
  for (int i = 0; i < links; ++i) {
    add(scene, {.shape = Capsule{.radius = 0.03, .half_height = 0.07},
                .position = from + (0.2 * i + 0.1) * along,
                .orientation = min_turn(Vector3::UnitZ(), along),
                .velocity = velocity});
    const std::size_t last = scene.bodies.size() - 1;
    if (i > 0) join(scene, BallJoint{}, last - 1, last, from + 0.2 * i * along);
  }
}

/// The figure of the scene of ragdolls, turned at random by `seed`.
inline void throw_ragdoll(Scene& scene, std::uint64_t seed, const Vector3& pelvis, const Vector3& velocity) {
  constexpr std::size_t parts = 13;
  const Scene doll = load_scene("ragdolls:count=1", seed);
  const std::size_t others = doll.bodies.size() - parts;
  const std::size_t first = scene.bodies.size();
  for (std::size_t i = others; i < doll.bodies.size(); ++i) {
    BodyDef part = doll.bodies[i].def;
    part.position += pelvis - doll.bodies[others].def.position;
    part.velocity = velocity;
    add(scene, part);
  }
  for (SceneJoint joint : doll.joints) {
    joint.name = "joint_" + std::to_string(scene.joints.size());
    joint.first += first - others;
    joint.second += first - others;
    scene.joints.push_back(joint);
  }
}

/// A heavy ball on a chain of 2 m that turns about a hook it hangs on. `angle` in rad, from -z to x; `speed` in m/s, of
/// the ball.
inline void swing_flail(Scene& scene, const Vector3& hook, double angle, double speed) {
  const Vector3 along(std::sin(angle), 0, -std::cos(angle)), across(-along.z(), 0, along.x());
  const std::size_t fixed = add(scene, {.type = BodyType::Static, .shape = Sphere{0.02}, .position = hook});
  throw_chain(scene, hook, along, 10, Vector3::Zero());
  join(scene, BallJoint{}, fixed, fixed + 1, hook);
  BodyDef tip = sphere(hook + 2.1 * along, 0.1);
  tip.density = 7800;
  const std::size_t ball = add(scene, tip);
  join(scene, BallJoint{}, ball - 1, ball, hook + 2 * along);
  for (std::size_t i = fixed + 1; i <= ball; ++i) {
    BodyDef& def = scene.bodies[i].def;
    def.velocity = speed / 2.1 * (def.position - hook).norm() * across;
    def.angular_velocity = {0, -speed / 2.1, 0};
  }
}

}  // namespace atl::test
