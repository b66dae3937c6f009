#pragma once

#include <solver/integrate/body_table.h>
#include <solver/integrate/solver_bodies.h>

#include <array>

// The rows of floats that kernels work on, as vectors and matrices in double.

namespace atl::solver {

inline Vector3 get3(const float (&from)[3]) { return {from[0], from[1], from[2]}; }

inline Vector3 get3(const std::array<float, 3>& from) { return {from[0], from[1], from[2]}; }

inline void set3(float (&to)[3], const Vector3& from) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

inline void add3(float (&to)[3], const Vector3& gain) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(to[i] + gain[i]);
}

/// How a body has turned since the start of the step.
inline Quaternion rotation_of(const DisplacementRows& displacement) {
  const float(&q)[4] = displacement.rotation;
  return {q[3], q[0], q[1], q[2]};
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
