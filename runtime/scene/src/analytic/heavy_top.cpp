// A symmetric top in steady precession on a ball that slides on the ground without friction.

#include "../analytic.h"
#include "comparison.h"
#include "setting.h"

namespace atl::scene {
namespace heavy_top {

constexpr double duration = 5;       // s
constexpr double tip_radius = 0.04;  // m, of the ball, at the origin of the body's frame
constexpr double disc_radius = 0.2;  // m
constexpr double disc_height = 0.2;  // m, above the ball's centre
constexpr Material smooth = {.friction = 0, .restitution = 0};

Vector3 axis_at(double azimuth, double tilt) {
  const auto [sine, cosine] = sine_cosine(tilt);
  return sine * heading(azimuth) + Vector3(0, 0, cosine);
}

}  // namespace heavy_top

Scene build_heavy_top(const ParameterValues& values, std::uint64_t) {
  using namespace heavy_top;
  Scene scene;
  scene.steps = steps_for(duration);
  scene.bodies.push_back(plane(smooth));

  const double tilt = values["tilt"], precession = values["precession"];
  Compound shape;
  shape.children.push_back({.shape = Sphere{tip_radius}});
  shape.children.push_back(
      {.shape = Cylinder{.radius = disc_radius, .half_height = 0.02}, .position = {0, 0, disc_height}});
  SceneBody top = solid("top", shape, {0, 0, tip_radius}, smooth);
  top.def.orientation = turned(tilt, Vector3::UnitY());

  // The weight and what holds it up act along vertical lines a horizontal l sin(tilt) apart, so the centre of mass
  // stays over its place and (I3 w3 - I1 W cos(tilt)) W = m g l.
  const MassProperties mass = body_mass(top.def);
  const double arm = mass.centre.z();
  const double i1 = mass.inertia(0, 0), i3 = mass.inertia(2, 2);
  const double spin = (mass.mass * standard_gravity * arm / precession + i1 * precession * axis_at(0, tilt).z()) / i3;
  top.def.angular_velocity =
      precession * Vector3::UnitZ() + (spin - precession * axis_at(0, tilt).z()) * axis_at(0, tilt);
  const Vector3 centre = top.def.position + arm * axis_at(0, tilt);
  scene.bodies.push_back(top);

  scene.closed_form = known_motion(
      "largest angle between the top's axis and the closed form's, relative to the tilt",
      "steady precession about a moving centre of mass: (I3 w3 - I1 W cos(tilt)) W = m g l; Goldstein, Classical "
      "Mechanics, section 5.7, with moments about the centre of mass",
      {{"centre_drift"}, {"tilt_error"}, {"spin_error"}},
      [=](double time, std::span<const BodyState> states, LargestErrors& errors) {
        const BodyState& state = states[1];
        const Vector3 axis = state.pose.orientation * Vector3::UnitZ();
        const Vector3 expected = axis_at(precession * time, tilt);
        errors.raise("analytic_error", std::atan2(axis.cross(expected).norm(), axis.dot(expected)) / tilt);
        const Vector3 moved = state.pose.position + arm * axis - centre;
        errors.raise("centre_drift", moved.head<2>().norm() / arm);
        errors.raise("tilt_error", std::abs(std::atan2(axis.head<2>().norm(), axis.z()) / tilt - 1));
        errors.raise("spin_error", std::abs(state.angular_velocity.dot(axis) / spin - 1));
      });
  return scene;
}

}  // namespace atl::scene
