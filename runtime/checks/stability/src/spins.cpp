#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include "cases.h"
#include "criteria.h"
#include "parts.h"

namespace atl::stability {
namespace {

constexpr double fast = 1000;  // rad/s

SceneBody rod() {
  SceneBody body = solid("rod", Capsule{.radius = 0.01, .half_height = 1}, {0, 0, 1.5}, scene::builtin_material);
  body.def.orientation = turned(90 * degree, Vector3::UnitY());
  return body;
}

SceneBody coin() {
  SceneBody body = solid("coin", Cylinder{.radius = 0.1, .half_height = 0.005}, {0, 0, 1}, scene::builtin_material);
  body.def.orientation = turned(90 * degree, Vector3::UnitY());
  return body;
}

const Vector3 needle_moments = {1e-7, 0.1, 0.1};  // kg m^2

// Principal moments that differ by 1e6: a rod without thickness to speak of.
SceneBody needle() {
  SceneBody body = solid("needle", Box{{0.5, 0.05, 0.05}}, {0, 0, 0.05}, scene::builtin_material);
  body.def.mass = 1;
  body.def.inertia = needle_moments.asDiagonal();
  return body;
}

// A symmetric top's axis turns about the angular momentum at the rate of that over the moment across the axis.
Criterion axis_error() {
  return {"axis_error", "rad", 1e-2, [](const History& run) {
            const BodyState& start = run.states.front()[0];
            const Vector3 momentum = needle_moments.cwiseProduct(start.angular_velocity);  // it starts along the axes
            const double time = static_cast<double>(run.states.size() - 1) * run.scene.dt;
            const Eigen::AngleAxisd turn(momentum.norm() / needle_moments.y() * time, momentum.normalized());
            const Vector3 expected = turn * Vector3::UnitX();
            const Vector3 axis = run.states.back()[0].pose.orientation * Vector3::UnitX();
            return std::atan2(axis.cross(expected).norm(), axis.dot(expected));
          }};
}

Scene alone(SceneBody body, const Vector3& spin) {
  Scene scene;
  scene.gravity.setZero();
  body.def.angular_velocity = spin;
  scene.bodies.push_back(body);
  return scene;
}

Scene above_ground(SceneBody body, const Vector3& spin) {
  Scene scene;
  scene.bodies.push_back(ground());
  body.def.angular_velocity = spin;
  scene.bodies.push_back(body);
  return scene;
}

void add_free(CaseList& cases, const std::string& name, const std::string& what, SceneBody (*body)(),
              const Vector3& spin) {
  cases.push_back({.name = name,
                   .what = what + ", without gravity",
                   .build = [body, spin] { return alone(body(), spin); },
                   .steps = 240,
                   .criteria = {energy_change(1e-3), angular_momentum_change(1e-2)}});
}

void add_landing(CaseList& cases, const std::string& name, const std::string& what, SceneBody (*body)(),
                 const Vector3& spin) {
  cases.push_back({.name = name,
                   .what = what + ", dropped",
                   .build = [body, spin] { return above_ground(body(), spin); },
                   .steps = 300,
                   .criteria = {energy_gain(1e-2), penetration(5e-3), travel_error(0.5)}});
}

// Marks criteria of the last case as known to fail.
void known_to_fail_last(CaseList& cases, std::initializer_list<std::string_view> names, const std::string& reason) {
  for (Criterion& criterion : cases.back().criteria) {
    if (std::find(names.begin(), names.end(), criterion.name) != names.end()) criterion.known_failure = reason;
  }
}

}  // namespace

void add_spins(CaseList& cases) {
  const char* const turns_far = "it turns by 4 rad a substep, of which contacts see the start";
  const Vector3 spin = fast * Vector3(0.1, 0.05, 1).normalized();
  add_free(cases, "rod-free", "rod of 2 m, 2 cm thick, that spins at 1000 rad/s", rod, spin);
  add_landing(cases, "rod-landing", "rod of 2 m, 2 cm thick, that spins at 1000 rad/s", rod, spin);
  known_to_fail_last(cases, {"travel_error"}, turns_far);
  add_free(cases, "coin-free", "coin that spins about a diameter at 1000 rad/s", coin, spin);
  add_landing(cases, "coin-landing", "coin that spins about a diameter at 1000 rad/s", coin, spin);
  known_to_fail_last(cases, {"travel_error"}, turns_far);

  add_free(cases, "needle-free", "body with moments of inertia of 1 to 1e6 that tumbles at 12 rad/s", needle,
           {10, 5, 3});
  cases.back().criteria.push_back(axis_error());
  add_landing(cases, "needle-landing", "body with moments of inertia of 1 to 1e6 that tumbles at 12 rad/s",
              [] {
                SceneBody body = needle();
                body.def.position.z() = 1;
                return body;
              },
              {10, 5, 3});
  cases.push_back({.name = "needle-lying",
                   .what = "body with moments of inertia of 1 to 1e6 that lies on the ground",
                   .build = [] { return above_ground(needle(), Vector3::Zero()); },
                   .criteria = {penetration(1e-3), drift(1e-2), tilt(1e-2), peak_speed(0.1), travel_error(0.1)}});
}

}  // namespace atl::stability
