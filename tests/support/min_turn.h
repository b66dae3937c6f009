#pragma once
/// The least turn between two directions.

#include <Eigen/Geometry>
#include <cmath>

namespace atl::test {

/// Takes one direction to another. Eigen's FromTwoVectors() does the same, but costs each file that calls it 7 s of the
/// compiler's time: where the two are opposites, it decomposes a matrix.
inline Eigen::Quaterniond min_turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d a = from.normalized(), b = to.normalized();
  constexpr double opposite = 1e-12;  // of 1 + cos
  const double above = 1 + a.dot(b);
  Eigen::Quaterniond turn;
  if (above < opposite) {
    turn.vec() = a.unitOrthogonal();
    turn.w() = 0;
  } else {
    const double twice_w = std::sqrt(2 * above);
    turn.vec() = a.cross(b) * (1 / twice_w);
    turn.w() = 0.5 * twice_w;
  }
  return turn;
}

}  // namespace atl::test
