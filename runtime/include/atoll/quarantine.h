#pragma once

#include <atoll/types.h>

#include <cstdint>

namespace atl {

/// Why a body was taken out of the world. Steps of up to 1 s and single precision within a step have room to spare
/// below these bounds, and nothing that bodies do beyond them means anything: at 1e6 m/s a speed in single precision is
/// a multiple of 6 cm/s, more than what tells resting from moving, and at 1e12 m a place in double precision is one of
/// 0.1 mm, and a bounding box one of 65 km.
enum class Quarantine {
  NotFinite,       ///< its pose, velocities, force or torque have a value that is infinite or not a number
  TooFar,          ///< its centre of mass is farther than 1e12 m from the origin
  TooFast,         ///< its speed is above 1e6 m/s
  TooFastSpin,     ///< its angular speed is above 1e6 rad/s
  TooFastSurface,  ///< its surface runs along it at more than 1e6 m/s or rad/s: see BodyDef::surface_velocity
  TooMuchForce,    ///< the forces on it would take its speed above 1e6 m/s in one step
  TooMuchTorque    ///< the torques on it would take its angular speed above 1e6 rad/s in one step
};

/// "its speed is above 1e6 m/s" and the like.
const char* quarantine_reason(Quarantine reason);

/// A body that is in quarantine: see World::quarantined().
struct Quarantined {
  BodyId id;
  Quarantine reason;
  const char* why;    ///< the reason in words
  std::int64_t step;  ///< of the world's, the first of which is 1: where it was taken out, at the start or the end
};

}  // namespace atl
