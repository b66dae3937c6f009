#pragma once
/// Vocabulary types of the public API. Units are SI, angles radians, everywhere.
///
/// Unless a field says otherwise, numbers are at most 1e15 in size, and numbers that must not be 0 are at least 1e-15:
/// steps compute in single precision, in which products of such numbers neither overflow nor underflow. For masses,
/// stiffnesses and the loads that break a joint the bounds are 1e30 and 1e-30. An Error refuses numbers beyond these
/// bounds. States, and the forces, gravity and motors that act on them, need only be finite: quarantine.h handles their
/// consequences.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>

namespace atl {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;

/// Its constructor takes w first, as Eigen's does; coeffs(), and arrays of orientations, have it last: x, y, z, w.
///
/// Unaligned, so that a program compiled with other vector flags than the library agrees on the
/// layout of every public struct. Converts to and from Eigen::Quaterniond.
using Quaternion = Eigen::Quaternion<double, Eigen::DontAlign>;

/// Position and orientation of a body's frame in the world. The body's shape is given in this frame.
struct Pose {
  Vector3 position = Vector3::Zero();  ///< m, of the frame's origin
  Quaternion orientation = Quaternion::Identity();

  bool operator==(const Pose&) const = default;
};

/// How a body moves: what any engine can tell of it.
struct BodyState {
  Pose pose = {};                              ///< of the body's frame
  Vector3 velocity = Vector3::Zero();          ///< m/s, world frame, of the centre of mass
  Vector3 angular_velocity = Vector3::Zero();  ///< rad/s, world frame
};

/// Names a body for its lifetime. The index is the body's column in the bulk views; it is used again
/// after the body is removed, with another generation, so a stale id is always recognised. Ids are the same in every
/// world that is made by the same calls, so one that belongs to another world can't be recognised.
struct BodyId {
  std::uint32_t index = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t generation = 0;

  friend auto operator<=>(const BodyId&, const BodyId&) = default;
};

}  // namespace atl

/// For unordered containers.
template <>
struct std::hash<atl::BodyId> {
  std::size_t operator()(const atl::BodyId& id) const noexcept {
    return std::hash<std::uint64_t>()(std::uint64_t{id.generation} << 32 | id.index);
  }
};
