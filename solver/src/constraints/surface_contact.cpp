#include <solver/constraints/surface_contact.h>

#include <algorithm>

#include "integrate/rows3.h"

namespace atl::solver {

bool note_surfaces_of(const collision::TouchingPair& pair, const BodyTable& bodies,
                      const collision::ContactManifold& manifold, const AddedSlip* added, SurfaceContact& contact) {
  static const Surface plain;
  const auto surface_of = [&](std::uint32_t body) -> const Surface& {
    return bodies.surfaces.empty() ? plain : bodies.surfaces[body];
  };
  const Surface& first = surface_of(pair.first);
  const Surface& second = surface_of(pair.second);
  // Kernels of a group without such surfaces leave it alone.
  if (!is_pressed(manifold) || contact.rolling_friction == 0) std::fill_n(contact.rolling_impulse, 3, 0.0f);
  set3(contact.slip,
       bodies.orientation(pair.second) * second.velocity - bodies.orientation(pair.first) * first.velocity);
  if (added == nullptr) return !first.is_plain() || !second.is_plain();
  bool slips = false;
  for (int i = 0; i < 3; ++i) {
    contact.slip[i] += added->velocity[i];
    slips |= added->velocity[i] != 0;
  }
  return slips || !first.is_plain() || !second.is_plain();
}

}  // namespace atl::solver
