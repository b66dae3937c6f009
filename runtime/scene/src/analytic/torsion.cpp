// Bodies that spin about the vertical, until torsional friction stops them.

#include <array>

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace torsion {

constexpr double radius = 0.5;                       // m
const Vector3 half_extents(0.5, 0.5, 0.25);          // m
constexpr std::array ball_shares = {1.0, 0.5, 0.0};  // of the parameter; without any a ball spins on
constexpr double box_share = 1;
constexpr double rest_of_duration = 0.5;  // s after the first has stopped

struct Spin {
  Vector3 start;
  double deceleration;  // rad/s^2
};

}  // namespace torsion

Scene build_torsion(const ParameterValues& values, std::uint64_t) {
  using namespace torsion;
  const double speed = values["spin"], torsion = values["torsional_friction"];
  Scene scene;
  scene.bodies.push_back(plane({.friction = 1}));
  std::vector<Spin> spins;
  const auto add = [&](SceneBody body, double squared_gyradius) {
    body.def.angular_velocity = speed * Vector3::UnitZ();
    spins.push_back({body.def.position, body.def.material.torsional_friction * standard_gravity / squared_gyradius});
    scene.bodies.push_back(std::move(body));
  };
  for (std::size_t i = 0; i < ball_shares.size(); ++i) {
    // One point of contact has no lever for the other friction.
    add(solid(numbered("ball", static_cast<int>(i)), Sphere{radius}, {0, 2.0 * static_cast<double>(i), radius},
              {.friction = 1, .torsional_friction = ball_shares[i] * torsion}),
        0.4 * radius * radius);
  }
  add(solid("box", Box{half_extents}, {0, -2, half_extents.z()},
            {.friction = 0, .torsional_friction = box_share * torsion}),
      (half_extents.x() * half_extents.x() + half_extents.y() * half_extents.y()) / 3);
  const double duration = speed / spins.front().deceleration + rest_of_duration;
  scene.steps = steps_for(duration);

  scene.closed_form = known_motion(
      "largest angle of a body's orientation from the closed form's, relative to the angle that it turns without "
      "friction",
      "the spin falls by torsional friction times m g / I, and ends at rest", {{"spin_error"}, {"drift"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        for (std::size_t i = 0; i < spins.size(); ++i) {
          const double deceleration = spins[i].deceleration;
          const double braked = deceleration * time < speed ? time : speed / deceleration;
          const double now = speed - deceleration * braked;
          const Quaternion expected = turned(0.5 * (speed + now) * braked, Vector3::UnitZ());
          const BodyState& state = states[i + 1];
          errors.raise("analytic_error", state.pose.orientation.angularDistance(expected) / (speed * duration));
          errors.raise("spin_error", (state.angular_velocity - now * Vector3::UnitZ()).norm() / speed);
          errors.raise("drift", (state.pose.position - spins[i].start).head<2>().norm() / radius);
        }
      });
  return scene;
}

}  // namespace atl::scene
