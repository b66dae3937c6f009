#pragma once

#include <collision/pose.h>
#include <jobs/arena.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// How much every body has turned in all since it was first seen: an odometer, whose difference over any time bounds
/// how far a point of the body at a distance of 1 m from its origin got by turning.
class BodyTurns {
 public:
  /// Adds the turn of a body since it was last looked at: the chord 2 sin(angle / 2), at a radius of 1.
  void follow(std::size_t body, const PoseView& poses);

  /// Makes room for `count` bodies, and follows those that are named.
  void follow(std::span<const std::uint32_t> bodies, std::size_t count, const PoseView& poses, jobs::Arena& arena);

  double operator[](std::size_t body) const { return turned_[body]; }
  std::size_t size() const { return turned_.size(); }

 private:
  std::vector<double> turned_;
  std::vector<std::array<double, 4>> last_;  // orientation x, y, z, w when last looked at; zero before
};

}  // namespace atl::collision
