#pragma once

#include <solver/integrate/body_table.h>
#include <solver/integrate/solver_bodies.h>

#include <array>

// The rows of floats that kernels work on, as vectors and matrices in double.

namespace atl::solver {

template <std::size_t n>
Vector3 get3(const float (&from)[n]) {
  return {from[0], from[1], from[2]};
}

inline Vector3 get3(const std::array<float, 3>& from) { return {from[0], from[1], from[2]}; }

inline void set3(float (&to)[3], const Vector3& from) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

template <std::size_t n>
void add3(float (&to)[n], const Vector3& gain) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(to[i] + gain[i]);
}

inline Vector3 get_lane(const float (&rows)[3][block_lanes], std::size_t lane) {
  return {rows[0][lane], rows[1][lane], rows[2][lane]};
}

/// m/s and rad/s, of a body as it is in the step.
inline Vector3 velocity_of(const SolverBodies& bodies, std::size_t local) {
  return get3(bodies.start_velocity[local].linear) + get3(bodies.velocity[local].linear);
}
inline Vector3 spin_of(const SolverBodies& bodies, std::size_t local) {
  return get3(bodies.start_velocity[local].angular) + get3(bodies.velocity[local].angular);
}

/// Gives a body velocities that are not carried over to the next substep, as what contacts do is.
inline void set_uncarried(SolverBodies& bodies, std::size_t local, const Vector3& velocity, const Vector3& spin) {
  VelocityRows& rows = bodies.velocity[local];
  FreeVelocityRows& free = bodies.free_velocity[local];
  add3(free.linear, velocity - velocity_of(bodies, local));
  add3(free.angular, spin - spin_of(bodies, local));
  set3(rows.linear, velocity - get3(bodies.start_velocity[local].linear));
  set3(rows.angular, spin - get3(bodies.start_velocity[local].angular));
}

/// Turns a body on from where its displacement has it.
inline void turn_on(SolverBodies& bodies, std::size_t local, const Quaternion& turn) {
  float(&rotation)[4] = bodies.displacement[local].rotation;
  const Quaternion turned = (turn * Quaternion(rotation[3], rotation[0], rotation[1], rotation[2])).normalized();
  for (int k = 0; k < 4; ++k) rotation[k] = static_cast<float>(turned.coeffs()[k]);
}

/// The turn of a body since the start of the step.
inline Quaternion rotation_of(const DisplacementRows& displacement) {
  const float(&q)[4] = displacement.rotation;
  return {q[3], q[0], q[1], q[2]};
}

/// 1/kg, along the world's axes: 0 along those that a body is locked along.
inline Vector3 inverse_mass_of(const SolverBodies& bodies, std::size_t local) {
  const Vector3 all = Vector3::Constant(bodies.free_velocity[local].inverse_mass);
  return bodies.locks.empty() ? all : all.cwiseProduct(get3(bodies.locks[local].free));
}

/// World frame.
inline Matrix3 inverse_inertia_of(const SolverBodies& bodies, std::size_t local) {
  const VelocityRows& v = bodies.velocity[local];
  const InertiaRow& rest = bodies.inertia[local];
  Matrix3 m;
  m << v.inertia_xx, rest.xy, rest.xz,  //
      rest.xy, v.inertia_yy, rest.yz,   //
      rest.xz, rest.yz, rest.zz;
  return m;
}

}  // namespace atl::solver
