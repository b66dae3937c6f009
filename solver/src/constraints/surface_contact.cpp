#include <solver/constraints/surface_contact.h>

#include <algorithm>

#include "integrate/rows3.h"

namespace atl::solver {

Vector3 surface_velocity_at(const BodyTable& bodies, std::uint32_t body, const Vector3& arm) {
  if (bodies.surfaces.empty() || bodies.surfaces[body].motion.is_zero()) return Vector3::Zero();
  const Surface& surface = bodies.surfaces[body];
  const Quaternion orientation = bodies.orientation(body);
  const Vector3 from_origin = arm + orientation * surface.centre;
  return orientation * surface.motion.velocity + surface_spin(bodies, body).cross(from_origin);
}

Vector3 surface_spin(const BodyTable& bodies, std::uint32_t body) {
  if (bodies.surfaces.empty()) return Vector3::Zero();
  return bodies.orientation(body) * bodies.surfaces[body].motion.angular_velocity;
}

bool update_surface_contact(const collision::TouchingPair& pair, const BodyTable& bodies,
                            const collision::ContactManifold& manifold, double ahead, const AddedSlip* added,
                            SurfaceContact& contact) {
  static const Surface plain;
  const auto surface_of = [&](std::uint32_t body) -> const Surface& {
    return bodies.surfaces.empty() ? plain : bodies.surfaces[body];
  };
  const Surface& first = surface_of(pair.first);
  const Surface& second = surface_of(pair.second);
  // Kernels of a group without such surfaces leave it alone.
  if (!has_impulse(manifold) || contact.rolling_friction == 0) std::fill_n(contact.rolling_impulse, 3, 0.0f);
  // A contact stays under the body that moves, and travels over the one that doesn't.
  const auto runs = [&](std::uint32_t body, std::uint32_t other, Vector3 arm) {
    if (bodies.mobility[body] != Mobility::Dynamic)
      arm += ahead * (bodies.velocity(other) - bodies.velocity_at(body, arm));
    return surface_velocity_at(bodies, body, arm);
  };
  set3(contact.slip, runs(pair.second, pair.first, get3(manifold.anchor_second)) -
                         runs(pair.first, pair.second, get3(manifold.anchor_first)));
  set3(contact.spin, surface_spin(bodies, pair.second) - surface_spin(bodies, pair.first));
  if (added == nullptr) return !first.is_plain() || !second.is_plain();
  bool slips = false;
  for (int i = 0; i < 3; ++i) {
    contact.slip[i] += added->velocity[i];
    slips |= added->velocity[i] != 0;
  }
  return slips || !first.is_plain() || !second.is_plain();
}

}  // namespace atl::solver
