// Balls on a box that is pushed over the ground: the rolling case of SimBenchmark.

#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace pushed_box {

constexpr double longest = 4;             // s
const Vector3 half_extents(10, 10, 0.5);  // m
constexpr double box_mass = 10;           // kg
constexpr double ball_mass = 1;           // kg
constexpr double radius = 0.5;            // m
constexpr int side = 5;                   // balls along each side of their grid
constexpr double spacing = 2;             // m
constexpr double ground_friction = 0.4;   // of the box on the ground
constexpr double ball_friction = 0.8;     // of the balls on the box

}  // namespace pushed_box

Scene build_pushed_box(const ParameterValues& values, std::uint64_t) {
  using namespace pushed_box;
  Scene scene;
  // The geometric means with the box's are the friction of the pairs.
  scene.bodies.push_back(plane({.friction = ground_friction}));
  SceneBody box = solid("box", Box{half_extents}, {0, 0, half_extents.z()}, {.friction = ground_friction});
  box.def.mass = box_mass;
  const Vector3 direction = heading(values["angle"]);
  box.force = values["force"] * direction;
  scene.bodies.push_back(box);
  for (int i = 0; i < side * side; ++i) {
    const Vector3 place(i % side - (side - 1) / 2, i / side - (side - 1) / 2, 0);
    SceneBody ball =
        solid(numbered("ball", i), Sphere{radius}, spacing * place + Vector3(0, 0, 2 * half_extents.z() + radius),
              {.friction = ball_friction * ball_friction / ground_friction});
    ball.def.mass = ball_mass;
    scene.bodies.push_back(ball);
  }

  // Friction f makes a ball roll on the box: its lowest point gains 7/2 f / m, as the box does, so that the ball gains
  // 2/7 of that.
  constexpr double balls = side * side * ball_mass;
  const double acceleration =
      (values["force"] - ground_friction * standard_gravity * (box_mass + balls)) / (box_mass + 2.0 / 7 * balls);
  // The balls fall behind by 5/7 of the box's way, and must not fall off: by 5 m at most.
  const double duration = std::min(longest, std::sqrt(2 * 5 * 7.0 / 5 / acceleration));
  const double path = 0.5 * acceleration * duration * duration;
  scene.steps = steps_for(duration);
  std::vector<Vector3> starts;
  for (const SceneBody& body : scene.bodies) starts.push_back(body.def.position);

  scene.closed_form = known_motion(
      "largest horizontal distance of the box or a ball from the closed form's place, relative to the box's path",
      "(F - mu g (M + n m)) / (M + 2/7 n m), and 2/7 of it for the balls; scene of Kang and Hwangbo, SimBenchmark, "
      "2018",
      {{"box_error"}, {"ball_error"}, {"lateral_drift"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        const double travelled = 0.5 * acceleration * time * time;
        for (std::size_t i = 1; i < starts.size(); ++i) {
          const Vector3 moved = states[i].pose.position - starts[i];
          const double share = i == 1 ? 1 : 2.0 / 7;
          const double along = moved.dot(direction);
          const double across = moved.dot(Vector3(-direction.y(), direction.x(), 0));
          errors.raise_with_total(i == 1 ? "box_error" : "ball_error",
                                  std::hypot(along - share * travelled, across) / path);
          errors.raise("lateral_drift", std::abs(across) / path);
        }
      });
  return scene;
}

}  // namespace atl::scene
