#include <solver/select/landing.h>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

bool is_fast(const BodyTable& bodies, std::uint32_t body, double min) {
  const double spin = bodies.radius[body] * bodies.radius[body] * bodies.angular_velocity(body).squaredNorm();
  return bodies.velocity(body).squaredNorm() + spin > min * min;
}

}  // namespace

bool lands(const LoadInput& input, std::size_t island) {
  const Islands& islands = input.islands;
  const BodyTable& bodies = input.bodies;
  if (islands.body_count(island) > 1) return false;
  // Slower landings don't count.
  const double gained = input.gravity.norm() * input.dt;
  if (!(gained > 0) || !is_fast(bodies, islands.bodies(island, island + 1).front(), gained)) return false;

  bool leans = false, reaches = false;
  for (const TouchingPair& pair : islands.contacts(island, island + 1)) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const Vector3 normal = get3(manifold.normal);
    const collision::Tangents tangents = collision::tangents(manifold.normal);
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      leans |= manifold.normal_impulse[i] > 0;
      const double gap = manifold.separation[i];
      if (reaches || gap <= 0 || gap >= collision::no_point) continue;
      const Vector3 off = manifold.x[i] * get3(tangents.first) + manifold.y[i] * get3(tangents.second);
      const Vector3 first = bodies.velocity_at(pair.first, get3(manifold.anchor_first) + off);
      const Vector3 second = bodies.velocity_at(pair.second, get3(manifold.anchor_second) + off);
      const double closing = normal.dot(first - second);
      reaches = closing > gained && gap < (closing + gained) * input.dt;
    }
  }
  return leans && reaches;
}

}  // namespace atl::solver
