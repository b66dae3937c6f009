#pragma once

#include <collision/shapes/pose.h>
#include <collision/shapes/shape.h>
#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <jobs/shared_values.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace atl::collision {

/// For jobs::SharedValues: the kind has padding after it.
inline std::array<std::uint64_t, sizeof(Shape) / sizeof(std::uint64_t)> words_of(const Shape& shape) {
  std::array<std::uint64_t, sizeof(Shape) / sizeof(std::uint64_t)> words;
  static_assert(offsetof(Shape, half_extents) == sizeof words[0]);
  std::memcpy(words.data(), static_cast<const void*>(&shape), sizeof shape);
  words[0] = static_cast<std::uint64_t>(shape.kind);
  return words;
}

/// The shapes of all bodies, each at its place on its body, as flat arrays. A compound has several, linked in
/// order of its children. Shapes that are alike are kept once. "Body frame" here is that of the body's centre of mass.
struct ColliderTable {
  static constexpr std::uint32_t none = ~0u;

  jobs::CompactArray<std::uint32_t> body;   ///< none where a collider is free
  jobs::CompactArray<std::uint32_t> child;  ///< its number in a compound, else 0
  jobs::CompactArray<std::uint32_t> next;   ///< the body's next collider, or none
  jobs::CompactArray<std::uint32_t> first;  ///< by body: its first collider, or none
  jobs::SharedValues<Shape> shape;
  /// The pose of the shape in the body frame.
  jobs::SharedValues<Pose> local = jobs::SharedValues<Pose>(Pose{Vector3::Zero(), Quaternion::Identity()});
  jobs::CompactArray<std::uint8_t> has_local_offset;  ///< 0 if `local` is the identity
  jobs::CompactArray<std::uint32_t> free;             ///< the last is used first

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(body, child, next, first, has_local_offset, free, shape, local); }

  std::size_t size() const { return body.size(); }

  void resize(std::size_t count) {
    jobs::append(body, count, none);
    jobs::append(child, count, std::uint32_t{0});
    jobs::append(next, count, none);
    shape.resize(count);
    local.resize(count);
    jobs::append(has_local_offset, count, std::uint8_t{0});
  }

  void resize_bodies(std::size_t count) { jobs::append(first, count, none); }

  /// Calls visit(collider) for each of a body, in order of its children.
  template <typename Visit>
  void for_each_of(std::uint32_t on_body, const Visit& visit) const {
    for (std::uint32_t collider = first[on_body]; collider != none; collider = next[collider]) visit(collider);
  }

  /// Puts a collider that is not in use, nor in the list of free ones, on a body. None follows it yet.
  void place(std::uint32_t collider, std::uint32_t on_body, std::uint32_t number, const Shape& what,
             const Pose& where) {
    body[collider] = on_body;
    child[collider] = number;
    next[collider] = none;
    shape.set(collider, what);
    local.set(collider, where);
    has_local_offset[collider] = !where.position.isZero(0) || !where.orientation.vec().isZero(0);
  }

  std::uint32_t add(std::uint32_t on_body, std::uint32_t number, const Shape& what, const Pose& where) {
    std::uint32_t collider = static_cast<std::uint32_t>(size());
    if (free.empty()) {
      resize(size() + 1);
    } else {
      collider = free.back();
      free.pop_back();
    }
    place(collider, on_body, number, what, where);
    return collider;
  }

  void remove(std::uint32_t collider) {
    body[collider] = none;
    free.push_back(collider);
  }

  /// World position of a collider's origin.
  Vector3 position(std::uint32_t collider, const PoseView& bodies) const {
    if (!has_local_offset[collider]) return bodies.position(body[collider]);
    const Pose frame = bodies[body[collider]];
    return frame.position + frame.orientation * local[collider].position;
  }

  /// World pose of a collider.
  Pose pose(std::uint32_t collider, const PoseView& bodies) const {
    const Pose frame = bodies[body[collider]];
    return has_local_offset[collider] ? collision::placed(frame, local[collider]) : frame;
  }
};

}  // namespace atl::collision
