#pragma once

#include <atoll/types.h>

#include <variant>

namespace atl {

/// Centred at the body's origin. radius > 0, in m.
struct Sphere {
  double radius = 0.5;
};

/// Centred at the body's origin, edges along the body's axes. Every half extent > 0, in m.
struct Box {
  Vector3 half_extents = {0.5, 0.5, 0.5};
};

/// All points p of the body frame with normal . p <= offset (m) are solid. The normal is normalised on
/// use and must not be zero. Only static and kinematic bodies may be half-spaces: its mass is infinite.
struct HalfSpace {
  Vector3 normal = {0, 0, 1};
  double offset = 0;
};

using Shape = std::variant<Box, Sphere, HalfSpace>;

}  // namespace atl
