#pragma once
/// Building blocks of the scenes with a closed form.

#include <atoll/scene.h>
#include <solver/integrate/trigonometry.h>

#include <cmath>
#include <string>
#include <utility>

#include "../building_blocks.h"

namespace atl::scene {

inline constexpr double standard_gravity = 9.81;  // m/s^2, of every scene that has gravity

/// The static half-space below the plane through the origin.
inline SceneBody plane(const Material& material, const Vector3& normal = {0, 0, 1}) {
  SceneBody body = solid_beyond("ground", normal, 0);
  body.def.material = material;
  return body;
}

/// A body at rest.
inline SceneBody solid(std::string name, Shape shape, const Vector3& position, const Material& material) {
  return {.name = std::move(name),
          .def = {.shape = std::move(shape), .position = position, .density = builtin_density, .material = material}};
}

inline std::string numbered(const char* kind, int number) { return std::string(kind) + "_" + std::to_string(number); }

/// Steps of the default length that cover a duration (s).
inline int steps_for(double duration) { return static_cast<int>(std::ceil(duration / Scene{}.dt - 1e-6)); }

// The start of a scene has to be the same on every machine, so it uses no function of the C library except the square
// root. The measures may use any: no state depends on them.
using solver::sine_cosine;

/// Unit vector in the x-y plane, rad from the x axis.
inline Vector3 heading(double angle) {
  const auto [sine, cosine] = sine_cosine(angle);
  return {cosine, sine, 0};
}

/// Rotation by an angle in rad about a unit vector.
inline Quaternion turned(double angle, const Vector3& axis) {
  const auto [sine, cosine] = sine_cosine(angle / 2);
  return {cosine, sine * axis.x(), sine * axis.y(), sine * axis.z()};
}

/// The angle, in (0, pi/2) rad, whose tangent is opposite / adjacent, both > 0: by Newton's method, which triples the
/// digits here.
inline double angle_of(double opposite, double adjacent) {
  const double length = std::sqrt(opposite * opposite + adjacent * adjacent);
  double angle = 0.785;
  for (int i = 0; i < 6; ++i) {
    const auto [sine, cosine] = sine_cosine(angle);
    angle -= (adjacent * sine - opposite * cosine) / length;
  }
  return angle;
}

}  // namespace atl::scene
