#pragma once
/// The momentum and energy of a world's bodies, by the audit, which shares no code with the solver or with mechanisms.

#include <atoll/atoll.h>
#include <atoll/errors.h>

#include <vector>

namespace atl::test {

/// Energy and momentum of all dynamic bodies.
inline MotionReport motion_of(const World& world) {
  std::vector<MovingBody> moving;
  for (const BodyId id : world.bodies()) {
    if (world.type(id) != BodyType::Dynamic) continue;
    const BodyDef def = world.definition(id);
    moving.push_back({body_mass(def), world.state(id), def.gravity_scale});
  }
  return measure_motion(moving, world.gravity());
}

}  // namespace atl::test
