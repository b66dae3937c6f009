// Spheres on a slope: they roll where friction is enough, and slide and spin where it is not.

#include <array>

#include "../analytic.h"
#include "slope.h"

namespace atl::scene {
namespace incline_sphere {

constexpr double duration = 2;                                 // s
constexpr double radius = 0.5;                                 // m
constexpr std::array ratios = {0.3, 0.6, 0.9, 1.1, 1.5, 3.0};  // of what rolling needs to the friction there is

}  // namespace incline_sphere

Scene build_incline_sphere(const ParameterValues& values, std::uint64_t) {
  using namespace incline_sphere;
  const Slope slope = {values["angle"]};
  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(plane({.friction = 1}, slope.normal()));
  const double pull = standard_gravity * slope.sine(), press = standard_gravity * slope.cosine();
  std::vector<Descent> descents;
  std::vector<double> spins;  // rad/s^2
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    const double friction = 2.0 / 7 * slope.sine() / slope.cosine() / ratios[i];
    const Vector3 start = radius * slope.normal() + Vector3(0, 2.0 * static_cast<double>(i), 0);
    scene.bodies.push_back(
        solid(numbered("ball", static_cast<int>(i)), Sphere{radius}, start, {.friction = friction * friction}));
    const bool rolls = ratios[i] < 1;
    descents.push_back({start, rolls ? 5.0 / 7 * pull : pull - friction * press});
    spins.push_back(rolls ? 5.0 / 7 * pull / radius : 2.5 * friction * press / radius);
  }
  const Compare places = compare_descents(slope, descents, duration, "position_error", "position_error");
  const double fastest = pull * duration / radius;
  scene.closed_form = known_motion(
      "largest distance of a sphere along the plane from the closed form's place, relative to its way without "
      "friction, and of its spin, relative to that of rolling without loss",
      "rolling: 5/7 g sin(a), where tan(a) <= 7/2 mu; else g (sin(a) - mu cos(a)) and spin at 5/2 mu g cos(a) / r",
      {{"position_error"}, {"spin_error"}}, [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        places(time, states, errors);
        for (std::size_t i = 0; i < spins.size(); ++i) {
          const Vector3 expected = spins[i] * time * Vector3::UnitY();
          errors.raise_with_total("spin_error", (states[i + 1].angular_velocity - expected).norm() / fastest);
        }
      });
  return scene;
}

}  // namespace atl::scene
