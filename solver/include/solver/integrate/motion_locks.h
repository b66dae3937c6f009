#pragma once

#include <solver/integrate/body_table.h>

#include <cstdint>

namespace atl::solver {

// A body's locks, as BodyTable holds them: motions along the world's axes x, y, z that it is without in bits 0 to 2,
// turns about them in bits 3 to 5. Velocities of locked bodies have no such parts, ever.

inline constexpr std::uint8_t all_locks = 63;
inline constexpr unsigned linear_locks(std::uint8_t locks) { return locks & 7u; }
inline constexpr unsigned angular_locks(std::uint8_t locks) { return locks >> 3u; }

/// The locks of a body that stays in its plane across an axis, 0 to 2.
inline constexpr std::uint8_t plane_locks(unsigned axis) {
  return static_cast<std::uint8_t>(1u << axis | (7u & ~(1u << axis)) << 3u);
}

/// The axis, 0 to 2, across which a body stays in its plane, or -1.
inline constexpr int plane_of(std::uint8_t locks) {
  for (unsigned axis = 0; axis < 3; ++axis) {
    if (locks == plane_locks(axis)) return static_cast<int>(axis);
  }
  return -1;
}

/// The same of the plane in which all stay that a contact of two bodies can move.
int shared_plane(const BodyTable& bodies, std::uint32_t first, std::uint32_t second);

/// A vector without its parts along the axes whose bits are set; zeros are positive.
inline Vector3 without(unsigned axes, const Vector3& v) {
  Vector3 rest;
  for (unsigned k = 0; k < 3; ++k) rest[k] = axes >> k & 1u ? 0 : v[k];
  return rest;
}

/// The inverse of an inertia on the axes whose bits are not set, and zero on the others, of which there are some.
Matrix3 inverse_on_free_axes(unsigned locked_axes, const Matrix3& inertia);

/// 1/(kg m^2), world frame: how a body answers a torque.
Matrix3 world_inverse_inertia(const BodyTable& bodies, std::uint32_t body);

/// m/s^2, of gravity and the force on a body.
Vector3 linear_acceleration(const BodyTable& bodies, std::uint32_t body, const Vector3& gravity);

/// The change of a body's spin by an angular impulse, rad/s; or its angular acceleration by a torque, rad/s^2.
Vector3 angular_response(const BodyTable& bodies, std::uint32_t body, const Vector3& torque);

}  // namespace atl::solver
