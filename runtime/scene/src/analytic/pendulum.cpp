// A rod that swings on a hinge.

#include "../analytic.h"
#include "comparison.h"
#include "free_top.h"
#include "rod.h"

namespace atl::scene {
namespace pendulum {

constexpr double duration = 5;  // s
constexpr double length = 1;    // m

}  // namespace pendulum

Scene build_pendulum(const ParameterValues& values, std::uint64_t) {
  using namespace pendulum;
  const double released = values["angle"];
  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(untouched(fixed_ball("hook", Vector3::Zero(), 0.05)));
  scene.bodies.push_back(hanging_rod("rod", length, Vector3::Zero(), released));
  join_last_two(scene, HingeJoint{}, Vector3::Zero(), swinging());

  const MassProperties mass = body_mass(scene.bodies.back().def);
  const double arm = length / 2;
  const double inertia = mass.inertia(1, 1) + mass.mass * arm * arm;
  const double rate = std::sqrt(mass.mass * standard_gravity * arm / inertia);
  scene.closed_form = known_motion(
      "largest difference of the rod's angle from the closed form's, relative to that at release",
      "sin(angle / 2) = k sn(K - p t, k), with k that of the release and p^2 = m g a / I: Landau and Lifshitz, "
      "Mechanics, section 11",
      {{"rate_error"}, {"off_plane", 0, "m"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        const double modulus = std::sin(released / 2);
        const Jacobi at = jacobi(std::comp_ellint_1(modulus) - rate * time, modulus);
        const double angle = 2 * std::asin(modulus * at.sn);
        // Solves (angle / 2)' cos(angle / 2) = -p k cn dn for the rate, where dn is the cosine.
        const double angle_rate = -2 * rate * modulus * at.cn;
        errors.raise("analytic_error", std::abs(angle_of_rod(states[1]) - angle) / released);
        errors.raise("rate_error", std::abs(-states[1].angular_velocity.y() - angle_rate) / (2 * rate * modulus));
        errors.raise("off_plane", std::abs(states[1].pose.position.y()));
      });
  return scene;
}

}  // namespace atl::scene
