#pragma once

#include <solver/body_table.h>

// Three numbers of the rows of floats that kernels work on.

namespace atl::solver {

inline Vector3 get3(const float (&from)[3]) { return {from[0], from[1], from[2]}; }

inline void set3(float (&to)[3], const Vector3& from) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

inline void add3(float (&to)[3], const Vector3& gain) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(to[i] + gain[i]);
}

}  // namespace atl::solver
