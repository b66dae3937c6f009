#pragma once

#include <solver/constraints/joint.h>

#include <cstdint>

namespace atl::solver {

/// A Law over a time step: the impulse along a coordinate as a function of the rate that it ends with. It falls as the
/// rate rises, piece by piece linear: what locks and stops is at least very slightly soft, the rest is as it is said to
/// be.
struct RowLaw {
  bool locked = false;
  double stiffness = 0;                 ///< N s by m/s, of what locks and stops
  double lock_rate = 0;                 ///< m/s or rad/s, at which a lock has no impulse
  double lower_rate = -Law::unlimited;  ///< at which the ends of the range are reached
  double upper_rate = Law::unlimited;
  double motor_speed = 0, motor_impulse = 0;  ///< the most that it has; 0 without
  double spring_slope = 0, spring_rate = 0;   ///< of impulse by rate, and the rate at which there is none; 0 without
  double spring_keeps = 0;                    ///< how the rate before the step adds to that

  /// `position` in m or rad, `effective_mass` along the coordinate in kg or kg m^2, h in s; what locks gives by
  /// `compliance` over the effective mass, or is left to the caller where that is 0. At rest before the step.
  static RowLaw of(const Law& law, double position, double effective_mass, double h, double compliance = 0);
  /// The same at a rate before the step's forces, once.
  void start_at(double rate) { spring_rate += spring_keeps * rate; }

  double impulse(double rate) const;
  /// Impulse by rate, not negative.
  double slope(double rate) const;
  /// A bit for each piece that the rate is on: the same pieces have the same slope.
  std::uint8_t pieces(double rate) const;
  /// Whether the position is held: locked, or at an end of the range.
  bool holds(double rate) const { return locked || rate < lower_rate || rate > upper_rate; }
  int limit(double rate) const { return locked ? 0 : rate < lower_rate ? -1 : rate > upper_rate ? 1 : 0; }
  int motor_bound(double rate) const;
};

}  // namespace atl::solver
