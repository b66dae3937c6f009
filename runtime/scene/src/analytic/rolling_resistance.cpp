// Spheres launched rolling in all directions, until rolling friction stops them.

#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace rolling_resistance {

constexpr double radius = 0.5;          // m
constexpr double friction = 0.6;        // enough that no sphere slips
constexpr double rest_of_duration = 1;  // s after all have stopped

}  // namespace rolling_resistance

Scene build_rolling_resistance(const ParameterValues& values, std::uint64_t) {
  using namespace rolling_resistance;
  const double speed = values["speed"];
  const int count = values.integer("headings");
  // The torque, rolling friction times m g, brakes the spin and, through the friction that keeps the sphere from
  // slipping, its mass.
  const double deceleration = values["rolling_friction"] * standard_gravity / radius / (1 + 2.0 / 5);
  const double stop = speed / deceleration;
  const double path = 0.5 * speed * stop;

  Scene scene;
  scene.steps = steps_for(stop + rest_of_duration);
  scene.bodies.push_back(plane({.friction = friction}));
  const double ring = std::max(1.0, 3 * radius * count / (2 * std::numbers::pi));
  std::vector<Vector3> starts, directions;
  for (int i = 0; i < count; ++i) {
    directions.push_back(heading(2 * std::numbers::pi * i / count));
    starts.push_back(ring * directions.back() + Vector3(0, 0, radius));
    SceneBody ball = solid(numbered("ball", i), Sphere{radius}, starts.back(),
                           {.friction = friction, .rolling_friction = values["rolling_friction"]});
    ball.def.velocity = speed * directions.back();
    ball.def.angular_velocity = speed / radius * Vector3::UnitZ().cross(directions.back());
    scene.bodies.push_back(ball);
  }

  scene.closed_form =
      known_motion("largest horizontal distance of a sphere from the closed form's place, relative to its path",
                   "rolls without slipping and slows down by rolling friction times g / r / (1 + 2/5), then stays",
                   {{"lateral_drift"}, {"speed_error"}, {"spin_error"}},
                   [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
                     const double braked = std::min(time, stop);
                     const double now = speed - deceleration * braked;
                     const double travelled = 0.5 * (speed + now) * braked;
                     for (std::size_t i = 0; i < starts.size(); ++i) {
                       const BodyState& state = states[i + 1];
                       const Vector3 side = Vector3::UnitZ().cross(directions[i]);
                       const Vector3 moved = state.pose.position - starts[i];
                       const double across = moved.dot(side);
                       errors.raise("analytic_error", std::hypot(moved.dot(directions[i]) - travelled, across) / path);
                       errors.raise("lateral_drift", std::abs(across) / path);
                       errors.raise("speed_error", std::abs(state.velocity.dot(directions[i]) - now) / speed);
                       errors.raise("spin_error", (radius * state.angular_velocity - now * side).norm() / speed);
                     }
                   });
  return scene;
}

}  // namespace atl::scene
