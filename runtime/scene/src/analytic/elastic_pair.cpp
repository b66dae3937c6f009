// Pairs of spheres that collide without loss: equal and unequal, head-on and obliquely.

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace elastic_pair {

constexpr double radius = 0.5;    // m
constexpr double light = 100;     // kg
constexpr double impact = 0.5;    // s, when the first pair touches;
constexpr double delay = 0.0037;  // s, for each pair more, so that impacts fall anywhere within a step
constexpr double before = 0.4;    // s: until then, and
constexpr double after = 0.8;     // s: from then on, velocities are compared, whatever the step
constexpr double duration = 1.2;  // s
constexpr Material elastic = {.friction = 0, .restitution = 1};

struct Collision {
  double mass_a, mass_b;  // kg
  Vector3 normal;         // from a to b as they touch
  double time;            // s, when they do
  bool oblique;
};

}  // namespace elastic_pair

Scene build_elastic_pair(const ParameterValues& values, std::uint64_t) {
  using namespace elastic_pair;
  Scene scene;
  scene.gravity = Vector3::Zero();
  scene.steps = steps_for(duration);
  scene.settings.restitution_threshold = 0;
  const double speed = values["speed"], heavy = values["ratio"] * light;
  const double lane = 4 * radius + 2 * speed * duration;  // m, wide enough that pairs never meet
  std::vector<Collision> collisions;
  for (const double offset : {0.0, values["offset"]}) {
    for (const auto& [mass_a, mass_b] : {std::pair(light, light), std::pair(light, heavy), std::pair(heavy, light)}) {
      const Vector3 normal(std::sqrt(1 - offset * offset), offset, 0);
      const auto number = static_cast<int>(collisions.size());
      const Vector3 place(0, lane * number, 0);
      const double touch = impact + number * delay;
      const Vector3 start = place - 2 * radius * normal - Vector3(speed * touch, 0, 0);
      SceneBody a = solid(numbered("moving", number), Sphere{radius}, start, elastic);
      SceneBody b = solid(numbered("resting", number), Sphere{radius}, place, elastic);
      a.def.mass = mass_a;
      a.def.velocity = {speed, 0, 0};
      b.def.mass = mass_b;
      scene.bodies.push_back(a);
      scene.bodies.push_back(b);
      collisions.push_back({mass_a, mass_b, normal, touch, offset != 0});
    }
  }

  scene.closed_form = known_motion(
      "largest difference of a sphere's velocity from the closed form's, relative to the speed of approach, but for "
      "the 0.4 s around the impact",
      "conservation of momentum and energy, with the impulse along the line of centres",
      {{"head_on_error"}, {"oblique_error"}, {"momentum_error"}, {"energy_error"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        if (time > before && time < after) return;
        const Vector3 approach(speed, 0, 0);
        for (std::size_t i = 0; i < collisions.size(); ++i) {
          const Collision& pair = collisions[i];
          const Vector3& a = states[2 * i].velocity;
          const Vector3& b = states[2 * i + 1].velocity;
          const double mass = pair.mass_a + pair.mass_b;
          const Vector3 exchanged =
              time < pair.time ? Vector3::Zero() : Vector3(2 * approach.dot(pair.normal) / mass * pair.normal);
          const double off =
              std::max((a - (approach - pair.mass_b * exchanged)).norm(), (b - pair.mass_a * exchanged).norm());
          errors.raise_with_total(pair.oblique ? "oblique_error" : "head_on_error", off / speed);
          errors.raise("momentum_error",
                       (pair.mass_a * (a - approach) + pair.mass_b * b).norm() / (pair.mass_a * speed));
          const double energy = pair.mass_a * a.squaredNorm() + pair.mass_b * b.squaredNorm();
          errors.raise("energy_error", std::abs(energy / (pair.mass_a * speed * speed) - 1));
        }
      });
  return scene;
}

}  // namespace atl::scene
