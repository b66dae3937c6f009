#pragma once

#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/manifold.h>

namespace atl::collision {

/// Solids are looked at that would meet within so many steps: forces may bring them together sooner than their speeds
/// say. Dominoes at 0.3 of their height, which fall faster as others lean on them, topple at 1.44 sqrt(g h): with 1 at
/// 1.29, with this at 1.38.
inline constexpr double steps_ahead = 1.5;

/// The contact of two solids where they will meet at the speeds that they have, as seen from where they are.
struct Meeting {
  Manifold manifold;
  Narrowphase by = Narrowphase::ClosedForm;
  Pose incident;  ///< now, in the frame of the reference
  Vector3 slip;   ///< m, world: how far the incident's place is now from the reference's, along their plane
};

}  // namespace atl::collision
