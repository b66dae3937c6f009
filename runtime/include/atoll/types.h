#pragma once
/// Vocabulary types of the public API. Units are SI, angles radians, everywhere.
///
/// Where nothing else is said, numbers are at most 1e15 in size, and those that must not be 0 at least 1e-15: steps
/// compute in single precision, to which products of such numbers are neither too large nor too small. For masses,
/// stiffnesses and what breaks a joint it is 1e30 and 1e-30. What is beyond is refused by an Error. States, and what acts
/// on them (forces, gravity, motors), need to be finite only: what they lead to is a matter of quarantine.h.

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

/// Where the frame of a body, in which its shape is given, lies in the world.
struct Pose {
  Vector3 position = Vector3::Zero();  ///< m, of the frame's origin
  Quaternion orientation = Quaternion::Identity();
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
