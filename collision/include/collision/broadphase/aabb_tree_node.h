#pragma once

#include <collision/shapes/aabb.h>

#include <bit>
#include <cstdint>
#include <limits>

namespace atl::collision {

/// A node of an AabbTree. It holds the boxes of both children, so that one cache line decides where a traversal goes
/// on. For each axis the lanes are (-lower, upper) of one child, then of the other. With the lower bounds negated, one
/// comparison of four lanes an axis tests both children, and a union is a maximum. Comparisons and negation are exact,
/// so results don't depend on the instruction set.
struct alignas(64) AabbTreeNode {
  using Lanes [[gnu::vector_size(16)]] = float;
  using Mask [[gnu::vector_size(16)]] = std::int64_t;  // of both lanes of a child

  /// A child that is not there.
  static constexpr std::int32_t none = std::numeric_limits<std::int32_t>::min();

  /// A box to test against nodes; it has the least lanes that a child's may have.
  struct Probe {
    explicit Probe(const Aabb& box) {
      for (std::size_t i = 0; i < 3; ++i) axis[i] = Lanes{-box.upper[i], box.lower[i], -box.upper[i], box.lower[i]};
    }
    Lanes axis[3];
  };

  Lanes axis[3];
  std::int32_t child[2] = {none, none};  // the number of a node, or a leaf's item with all bits inverted
  std::int32_t parent = none;            // the slot 2 * node + side that this node is in; in the free list, the next
  std::int32_t height = 1;               // over leaves

  AabbTreeNode() {
    clear(0);
    clear(1);
  }

  static bool is_leaf(std::int32_t child) { return child < 0 && child != none; }
  static bool is_node(std::int32_t child) { return child >= 0; }

  Aabb box(int side) const {
    const int at = 2 * side;
    return {{-axis[0][at], -axis[1][at], -axis[2][at]}, {axis[0][at + 1], axis[1][at + 1], axis[2][at + 1]}};
  }

  void set_box(int side, const Aabb& box) {
    for (std::size_t i = 0; i < 3; ++i) {
      axis[i][2 * side] = -box.lower[i];
      axis[i][2 * side + 1] = box.upper[i];
    }
  }

  /// Removes a child. An absent child's box overlaps nothing.
  void clear(int side) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    child[side] = none;
    set_box(side, {{nan, nan, nan}, {nan, nan, nan}});
  }

  /// The box around both children. Numbers that are NaN count as nothing, so that they hide no other box.
  Aabb joined() const {
    Aabb box;
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = -larger(axis[i][0], axis[i][2]);
      box.upper[i] = larger(axis[i][1], axis[i][3]);
    }
    return box;
  }

  /// Bit 0: the first child's box overlaps; bit 1: the second one's.
  unsigned overlaps(const Probe& probe) const {
    const auto inside = (axis[0] >= probe.axis[0]) & (axis[1] >= probe.axis[1]) & (axis[2] >= probe.axis[2]);
    const auto both = std::bit_cast<Mask>(inside);
    return unsigned{both[0] == -1} | unsigned{both[1] == -1} << 1;
  }

 private:
  static float larger(float a, float b) {
    const float known = a > -std::numeric_limits<float>::infinity() ? a : -std::numeric_limits<float>::infinity();
    return b > known ? b : known;
  }
};

}  // namespace atl::collision
