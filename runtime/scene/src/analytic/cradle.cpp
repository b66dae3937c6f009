// Newton's cradle without strings: of a row of equal spheres, a little apart, one is hit and the last one leaves.

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace cradle {

constexpr double radius = 0.5;     // m
constexpr double impact = 0.5037;  // s, the first: within a step, not at its end
constexpr double margin = 0.3;     // s, around all impacts, in which nothing is compared
constexpr Material elastic = {.friction = 0, .restitution = 1};

}  // namespace cradle

Scene build_cradle(const ParameterValues& values, std::uint64_t) {
  using namespace cradle;
  const int count = values.integer("count");
  const double speed = values["speed"], gap = values["gap"];
  const double last_impact = impact + (count - 1) * gap / speed;

  Scene scene;
  scene.gravity = Vector3::Zero();
  scene.steps = steps_for(last_impact + 2 * margin);
  scene.settings.restitution_threshold = 0;
  for (int i = 0; i <= count; ++i) {
    const double x = i == 0 ? -2 * radius - speed * impact : (i - 1) * (2 * radius + gap);
    SceneBody ball = solid(numbered("ball", i), Sphere{radius}, {x, 0, 0}, elastic);
    if (i == 0) ball.def.velocity = {speed, 0, 0};
    scene.bodies.push_back(ball);
  }

  // The gaps make it one collision of two after the other, and each of them hands all of the motion on.
  scene.closed_form = known_motion(
      "largest difference of a sphere's velocity from the closed form's, relative to the first one's, but for 0.3 s "
      "before the first and after the last impact",
      "conservation of momentum and energy in each collision of two equal spheres: they exchange their velocities",
      {{"last_error"}, {"others_error"}, {"momentum_error"}, {"energy_error"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        if (time > impact - margin && time < last_impact + margin) return;
        const std::size_t moving = time < impact ? 0 : states.size() - 1;
        Vector3 momentum = Vector3::Zero();
        double energy = 0;
        for (std::size_t i = 0; i < states.size(); ++i) {
          const Vector3& velocity = states[i].velocity;
          const Vector3 expected(i == moving ? speed : 0, 0, 0);
          errors.raise_with_total(i == moving ? "last_error" : "others_error", (velocity - expected).norm() / speed);
          momentum += velocity;
          energy += velocity.squaredNorm();
        }
        errors.raise("momentum_error", (momentum - Vector3(speed, 0, 0)).norm() / speed);
        errors.raise("energy_error", std::abs(energy / (speed * speed) - 1));
      });
  return scene;
}

}  // namespace atl::scene
