#pragma once

namespace atl::solver {

/// A damped spring over a time step, so that a body alone on it moves as the closed form has it, to the rounding error,
/// in semi-implicit Euler's leapfrog of positions and velocities: with the rate u before the step and the position x
/// from rest, a rate that everything else makes u0 becomes (u0 + keep * u - pull * x) / (1 + hold). A constant force is
/// answered by its static deflection. Exact maps are always stable; a spring that would swing by more than `max_phase`
/// in a step, which nobody could see, is damped so far that it swings by that.
struct SpringStep {
  static constexpr double max_phase = 1;      ///< rad
  static constexpr double unlimited = 1e300;  ///< part of the distance from rest

  double hold = 0;
  double keep = 0;
  double pull = 0;  ///< 1/s

  /// `omega` = sqrt(k / m) in rad/s, `decay` = c / m in 1/s, h in s; all >= 0. A body at rest is moved by at most
  /// `max_closed` of its distance from rest, by damping the spring beyond what it is.
  static SpringStep of(double omega, double decay, double h, double max_closed = unlimited);
};

}  // namespace atl::solver
