#include <algorithm>

#include "cases.h"
#include "criteria.h"
#include "parts.h"
#include "scene/src/lattice.h"
#include "scene/src/random.h"

namespace atl::stability {
namespace {

constexpr std::size_t hit_box = 3;  // the middle one of five, after the ground
constexpr std::size_t bullet_place = 6;

Scene bullet_into_stack() {
  Scene scene = tower(5);
  scene.starts_at_rest = false;
  SceneBody bullet = solid("bullet", Sphere{0.05}, {-10, 0, 2.5}, scene::builtin_material);
  bullet.def.density = 8000;
  bullet.def.velocity = {200, 0, 0};
  scene.bodies.push_back(bullet);
  return scene;
}

// How far the bullet was ever ahead of the middle of the box that it hits.
Criterion passed_through() {
  return {"passed_through", "m", 0, [](const History& run) {
            double ahead = 0;
            for (const auto& states : run.states) {
              ahead = std::max(ahead, states[bullet_place].pose.position.x() - states[hit_box].pose.position.x());
            }
            return ahead;
          }};
}

// 20 balls without friction or loss in a closed box.
Scene crowd() {
  const Material lossless = {.friction = 0, .restitution = 1};
  constexpr double half = 2, radius = 0.3;  // m
  constexpr std::size_t balls = 20;
  Scene scene;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      SceneBody wall = plane(lossless, -side * Vector3::Unit(axis));
      wall.name = numbered("wall", static_cast<int>(scene.bodies.size()));
      wall.def.position = Vector3(0, 0, half) + side * half * Vector3::Unit(axis);
      scene.bodies.push_back(wall);
    }
  }
  scene::Random random(1);
  const scene::Lattice lattice = {.count = {3, 3, 3}, .spacing = {1.1, 1.1, 1.1}};
  for (const Vector3& point : lattice.points()) {
    if (scene.bodies.size() == 6 + balls) break;
    scene.bodies.push_back(solid(numbered("ball", static_cast<int>(scene.bodies.size())), Sphere{radius},
                                 point + Vector3(0, 0, 0.9), lossless));
    scene.bodies.back().def.velocity = random.in_box(Vector3::Constant(5));
  }
  return scene;
}

}  // namespace

void add_impacts(CaseList& cases) {
  cases.push_back({.name = "bullet",
                   .what = "bullet of 4 kg that hits the middle of a stack of five at 200 m/s",
                   .build = bullet_into_stack,
                   .steps = 180,
                   .criteria = {energy_gain(1e-2), penetration(5e-3), passed_through()}});
  cases.push_back({.name = "lossless-crowd",
                   .what = "20 balls of restitution 1 in a closed box",
                   .build = crowd,
                   .steps = 600,
                   .criteria = {energy_gain(1e-2), penetration(5e-3)}});
}

}  // namespace atl::stability
