#pragma once

#include <atoll/types.h>

#include <array>

namespace atl::scene {

/// Jacobi's elliptic functions of an argument and a modulus k in [0, 1].
struct Jacobi {
  double sn, cn, dn;
};
Jacobi jacobi(double argument, double modulus);

/// Torque-free rotation of a body with three different principal moments, from Landau and Lifshitz, "Mechanics",
/// section 37: the angular velocity in Jacobi's elliptic functions. Two angles of the orientation follow from the
/// angular momentum, constant in space and known in the body; the third, about it, is an integral over time.
class FreeTop {
 public:
  /// Moments (kg m^2) about the body's axes; spin (rad/s) along them at time 0. The spin must not lie on the
  /// separatrix, where the body takes for ever to turn over.
  FreeTop(const Vector3& moments, const Vector3& spin, const Quaternion& orientation);

  Vector3 spin(double time) const;  ///< rad/s, body frame
  /// Times must not decrease from call to call: the angle about the angular momentum is summed up on the way.
  Quaternion orientation(double time);

 private:
  double precession_rate(double time) const;
  Matrix3 relative_to_momentum(const Vector3& spin) const;

  Vector3 moments_;
  std::array<int, 3> axes_;  // around which the momentum does not go, the middle one, around which it does
  Vector3 amplitudes_;       // rad/s, of cn, sn and dn, signed, in the order of axes_
  double rate_ = 0;          // argument per second
  double modulus_ = 0;
  double argument_ = 0;      // at time 0
  double twice_energy_ = 0;  // J
  double momentum_ = 0;      // kg m^2/s
  double typical_rate_ = 0;  // rad/s, the fastest that anything turns
  Quaternion to_space_;      // from the frame with z along the angular momentum
  double angle_ = 0;         // rad, about the angular momentum, since time_ = 0
  double time_ = 0;          // s
};

}  // namespace atl::scene
