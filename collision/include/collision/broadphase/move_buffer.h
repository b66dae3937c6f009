#pragma once

#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <algorithm>
#include <cstdint>
#include <span>

namespace atl::collision {

/// The shapes that have moved, or changed otherwise, since the last clear(), each once. One that is removed stays in
/// it: to look for it takes too long.
class MoveBuffer {
 public:
  /// Must be called before a shape is marked or asked for.
  void make_room_for(std::uint32_t shape) {
    if (shape >= moved_.size()) jobs::append(moved_, shape + std::size_t{1});
  }
  void mark(std::uint32_t shape) {
    if (contains(shape)) return;
    moved_[shape] = 1;
    shapes_.push_back(shape);
  }
  bool contains(std::uint32_t shape) const { return moved_[shape] != 0; }
  /// The marked shapes, in the order in which they were marked.
  std::span<const std::uint32_t> shapes() const { return shapes_; }
  void clear() {
    if (shapes_.size() < moved_.size() / 16) {
      for (const std::uint32_t shape : shapes_) moved_[shape] = 0;
    } else {
      std::fill(moved_.begin(), moved_.end(), std::uint8_t{0});
    }
    shapes_.clear();
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(moved_, shapes_); }

 private:
  jobs::CompactArray<std::uint8_t> moved_;  // by shape: 1 if it is in shapes_
  jobs::CompactArray<std::uint32_t> shapes_;
};

}  // namespace atl::collision
