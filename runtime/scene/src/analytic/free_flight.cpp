// Bodies thrown without anything to touch: parabolas, and spin about a fixed axis of those that have one.

#include <numbers>

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace free_flight {

constexpr int thrown = 8;
constexpr double duration = 3;  // s

struct Throw {
  Vector3 position;
  Vector3 velocity;
  Vector3 spin;
};

// Spheres and cubes, which spin about any axis, and boxes and capsules, which do about an axis of symmetry.
Shape thrown_shape(int number) {
  switch (number % 4) {
    case 0:
      return Sphere{0.4};
    case 1:
      return Box{Vector3::Constant(0.3)};
    case 2:
      return Box{{0.5, 0.2, 0.3}};
    default:
      return Capsule{.radius = 0.2, .half_height = 0.3};
  }
}

Vector3 spin_axis(int number) {
  return number % 4 < 2 ? Vector3(Vector3(1, 0.3 * number, -0.7).normalized()) : Vector3(0, 0, 1);
}

double turn(const Vector3& spin, double time, const Quaternion& orientation) {
  const double rate = spin.norm();
  if (rate == 0) return orientation.angularDistance(Quaternion::Identity());
  return orientation.angularDistance(Quaternion(Eigen::AngleAxisd(rate * time, spin / rate)));
}

}  // namespace free_flight

Scene build_free_flight(const ParameterValues& values, std::uint64_t) {
  using namespace free_flight;
  Scene scene;
  scene.steps = steps_for(duration);
  std::vector<Throw> throws;
  for (int i = 0; i < thrown; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / thrown;
    const double elevation = std::numbers::pi / 2 * i / thrown;
    const auto [sine, cosine] = sine_cosine(elevation);
    const Throw thrown_so = {5 * heading(azimuth) + Vector3(0, 0, 20),
                             values["speed"] * (cosine * heading(azimuth) + Vector3(0, 0, sine)),
                             values["spin"] * spin_axis(i)};
    throws.push_back(thrown_so);
    SceneBody body = solid(numbered("body", i), thrown_shape(i), thrown_so.position, {});
    body.def.velocity = thrown_so.velocity;
    body.def.angular_velocity = thrown_so.spin;
    scene.bodies.push_back(body);
  }

  const Vector3 gravity = scene.gravity;
  scene.closed_form = known_motion(
      "largest distance of a body from its parabola, relative to |v0| t + g t^2 / 2, and of its orientation from a "
      "steady turn, relative to 1 rad plus the angle turned",
      "constant acceleration: x0 + v0 t + g t^2 / 2; torque-free spin about a principal axis is constant",
      {{"position_error"}, {"orientation_error"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        for (std::size_t i = 0; i < throws.size(); ++i) {
          const Throw& start = throws[i];
          const Vector3 expected = start.position + time * start.velocity + 0.5 * time * time * gravity;
          const double path = time * start.velocity.norm() + 0.5 * time * time * gravity.norm();
          errors.raise_with_total("position_error", (states[i].pose.position - expected).norm() / path);
          const double error = turn(start.spin, time, states[i].pose.orientation);
          errors.raise_with_total("orientation_error", error / (1 + start.spin.norm() * time));
        }
      });
  return scene;
}

}  // namespace atl::scene
