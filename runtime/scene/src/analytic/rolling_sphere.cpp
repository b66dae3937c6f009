// Spheres launched sliding in all directions without spin, until friction makes them roll.

#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace rolling_sphere {

constexpr double radius = 0.5;  // m

}  // namespace rolling_sphere

Scene build_rolling_sphere(const ParameterValues& values, std::uint64_t) {
  using namespace rolling_sphere;
  const double friction = values["friction"], speed = values["speed"];
  const int count = values.integer("headings");
  const double deceleration = friction * standard_gravity;
  const double rolling = 2 * speed / (7 * deceleration);  // s, when it begins
  const double slid = speed * rolling - 0.5 * deceleration * rolling * rolling;
  const double duration = 3 * rolling;
  const double path = slid + 5.0 / 7 * speed * (duration - rolling);

  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(plane({.friction = friction}));
  const double ring = std::max(1.0, 3 * radius * count / (2 * std::numbers::pi));
  std::vector<Vector3> starts, directions;
  for (int i = 0; i < count; ++i) {
    directions.push_back(heading(2 * std::numbers::pi * i / count));
    starts.push_back(ring * directions.back() + Vector3(0, 0, radius));
    SceneBody ball = solid(numbered("ball", i), Sphere{radius}, starts.back(), {.friction = friction});
    ball.def.velocity = speed * directions.back();
    scene.bodies.push_back(ball);
  }

  scene.closed_form =
      known_motion("largest horizontal distance of a sphere from the closed form's place, relative to its path",
                   "angular momentum about the point of contact is constant: rolls at 5/7 v from t = 2 v / (7 mu g)",
                   {{"lateral_drift"}, {"speed_error"}, {"spin_error"}},
                   [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
                     const double braked = std::min(time, rolling);
                     const double travelled =
                         speed * braked - 0.5 * deceleration * braked * braked + 5.0 / 7 * speed * (time - braked);
                     const double now = speed - deceleration * braked;
                     const double spin = 2.5 * deceleration * braked / radius;
                     for (std::size_t i = 0; i < starts.size(); ++i) {
                       const BodyState& state = states[i + 1];
                       const Vector3 side(-directions[i].y(), directions[i].x(), 0);
                       const Vector3 moved = state.pose.position - starts[i];
                       const double across = moved.dot(side);
                       errors.raise("analytic_error", std::hypot(moved.dot(directions[i]) - travelled, across) / path);
                       errors.raise("lateral_drift", std::abs(across) / path);
                       errors.raise("speed_error", std::abs(state.velocity.dot(directions[i]) - now) / speed);
                       errors.raise("spin_error", (state.angular_velocity - spin * side).norm() * radius / speed);
                     }
                   });
  return scene;
}

}  // namespace atl::scene
