#pragma once

#include <solver/integrate/body_table.h>

namespace atl::solver {

// Bounds that no body of a sensible simulation exceeds. Within them, single precision has room for the squares and
// products that a step makes of displacements and speeds; see atoll/quarantine.h.
inline constexpr double farthest = 1e12;  ///< m, of the centre of mass from the origin
inline constexpr double top_speed = 1e6;  ///< m/s
inline constexpr double top_spin = 1e6;   ///< rad/s

/// True if a pose is finite and its position within bounds. The form makes the answer false for NaN: finite terms of
/// any size keep 0 * sum at 0, others don't.
inline bool is_in_place(const Vector3& position, const Quaternion& orientation) {
  return position.squaredNorm() <= farthest * farthest && 0 * orientation.coeffs().sum() == 0;
}

/// True if a body's pose and velocities are finite and within bounds.
inline bool is_sound(const BodyTable& bodies, std::size_t body) {
  return is_in_place(bodies.position(body), bodies.orientation(body)) && bodies.velocity(body).norm() <= top_speed &&
         bodies.angular_velocity(body).norm() <= top_spin;
}

}  // namespace atl::solver
