#pragma once

#include <solver/motion.h>

#include <cstdint>
#include <vector>

namespace atl {

/// How a body moved in a step in which it was fast.
struct FastMove {
  std::uint32_t body;
  solver::BodyPose start;
  Vector3 shift;  ///< m, of the centre of mass
  double turn;    ///< m: no point of it got farther by turning
};

/// A surface that a fast body's core touches as the step starts.
struct HeldBy {
  Vector3 normal;  ///< unit, from the core to the surface
  double excess;   ///< m, how far the core ends beyond it
  double slack;    ///< m, it is to end before the surface by a part of this
};

/// How far a fast body gets.
struct FastStop {
  double t = 1;                     ///< part of its motion
  Vector3 aside = Vector3::Zero();  ///< m, added to its end
};

/// Memory of a worker that sweeps fast bodies.
struct FastSweep {
  std::vector<std::uint32_t> nearby;  // colliders
  std::vector<HeldBy> held;
};

}  // namespace atl
