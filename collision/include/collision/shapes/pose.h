#pragma once

#include <collision/shapes/shape.h>

#include <Eigen/Geometry>

namespace atl::collision {

using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

struct Pose {
  Vector3 position;
  Quaternion orientation;
};

/// Poses of all bodies, as flat arrays: 3 doubles of position and 4 (x, y, z, w) of orientation each.
struct PoseView {
  const double* positions;
  const double* orientations;

  Vector3 position(std::size_t body) const { return Eigen::Map<const Vector3>(positions + 3 * body); }
  Pose operator[](std::size_t body) const {
    const double* p = positions + 3 * body;
    const double* q = orientations + 4 * body;
    return {Vector3(p[0], p[1], p[2]), Quaternion(q[3], q[0], q[1], q[2])};
  }
};

/// World pose of what has the pose `local` in a frame.
inline Pose placed(const Pose& frame, const Pose& local) {
  return {frame.position + frame.orientation * local.position, frame.orientation * local.orientation};
}

/// The frame of `b` as seen from that of `a`.
inline Pose relative(const Pose& a, const Pose& b) {
  const Quaternion inverse = a.orientation.conjugate();
  return {inverse * (b.position - a.position), inverse * b.orientation};
}

}  // namespace atl::collision
