#pragma once

#include <collision/shapes/aabb.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Static tree of boxes over the triangles of a surface: eight children a node, whose boxes are kept in 124 steps of
/// the node's own, a byte a bound, so that a node takes 128 bytes and all its children are tested at once. Which items
/// a query finds doesn't depend on the steps: items have their boxes as they are.
///
/// After Ylitie, Karras and Laine, "Efficient incoherent ray traversal on GPUs through compressed wide BVHs", HPG 2017.
struct TriangleTree {
  static constexpr std::size_t width = 8;

  struct alignas(64) Node {
    // A byte a child, from the lowest on, up to 127; those of `upper` have their top bit set. Children that aren't
    // there lie beyond all steps.
    std::array<std::uint64_t, 3> lower, upper;
    Eigen::Array4f origin;                  // m; x, y, z
    Eigen::Array4f steps;                   // a metre
    std::array<std::uint8_t, width> place;  // among the node's children of its kind
    std::uint32_t first_node;               // of the children that are nodes, which stand in a row
    std::uint32_t first_item;               // of those that are items
    std::uint8_t inner;                     // bits: which children are nodes
    std::uint8_t count;

    bool is_inner(std::size_t child) const { return (inner >> child & 1) != 0; }
    /// Index of a child among nodes, or among items.
    std::uint32_t child(std::size_t i) const { return (is_inner(i) ? first_node : first_item) + place[i]; }
    /// Children that may overlap a box, which has no NaN, among them all that do: the top bits of their bytes.
    std::uint64_t near(const Aabb& box) const;

   private:
    friend struct TriangleTree;
    Eigen::Array4i steps_to(const std::array<float, 3>& corner) const;
    void set_bounds(std::size_t child, const Aabb& box);
  };

  std::vector<Node> nodes;           ///< the root first
  std::vector<Aabb> node_boxes;      ///< by node
  std::vector<std::uint32_t> items;  ///< triangles, those of a node in a row
  std::vector<Aabb> boxes;           ///< by place in `items`

  /// Splits by the surface area heuristic in bins along the longest axis of the centres (Wald, "On fast
  /// construction of SAH-based bounding volume hierarchies", 2007), down to one item, and takes levels together.
  void build(std::span<const Aabb> item_boxes);

  /// Calls visit(item) for every item whose box overlaps, in the tree's order.
  template <typename Visit>
  void query(const Aabb& box, const Visit& visit) const {
    query_boxes(box, [&visit](std::uint32_t item, const Aabb&) { visit(item); });
  }
  /// The same with visit(item, box of the item).
  template <typename Visit>
  void query_boxes(const Aabb& box, const Visit& visit) const;

  /// Calls visit(item) for items whose boxes are within a limit, of what is known by then the nearest first.
  /// measure(box) is how far a box is, at most as far as what lies in it, or NaN if it is not to be visited; limit()
  /// may shrink.
  template <typename Measure, typename Limit, typename Visit>
  void visit_near(const Measure& measure, const Limit& limit, const Visit& visit) const;

  // Splits are at the median below 48 levels, and there are fewer than 2^32 items.
  static constexpr std::size_t max_depth = 48 + 32;

  struct BinaryNode;  // of the tree that it is made of

 private:
  static constexpr std::uint64_t each = 0x0101010101010101;
  static constexpr std::uint64_t top_bits = 0x80 * each;
  static constexpr float last_step = 126;
  static constexpr std::uint64_t beyond = 127;

  static std::size_t child_of(std::uint64_t bits) { return static_cast<std::size_t>(std::countr_zero(bits)) / 8; }
  static Node frame_of(const Aabb& box);
  void take(std::span<const BinaryNode> binary);
};

// The step in which a coordinate lies, 0 below the origin. Never falls as the coordinate grows, rounded as it may be:
// boxes that overlap do so in steps.
inline Eigen::Array4i TriangleTree::Node::steps_to(const std::array<float, 3>& corner) const {
  const Eigen::Array4f at(corner[0], corner[1], corner[2], 0);
  return ((at - origin) * steps + 1).max(0).min(last_step).cast<int>();
}

// Compares eight bytes at once: the top bit of a byte stays in a - b if the byte of a (whose top bit is set) is not
// less than the byte of b.
inline std::uint64_t TriangleTree::Node::near(const Aabb& box) const {
  const Eigen::Array4i from = steps_to(box.lower);
  const Eigen::Array4i to = steps_to(box.upper);
  std::uint64_t result = top_bits;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    result &= (static_cast<std::uint64_t>(to[axis]) * each | top_bits) - lower[i];
    result &= upper[i] - static_cast<std::uint64_t>(from[axis]) * each;
  }
  return result;
}

template <typename Visit>
void TriangleTree::query_boxes(const Aabb& box, const Visit& visit) const {
  const Aabb known = box.known_or_nan();
  if (nodes.empty() || known.lower[0] != known.lower[0]) return;
  struct Level {
    const Node* node;
    std::uint64_t near;  // children that are left
  };
  Level stack[max_depth];
  std::size_t top = 0;
  Level level{nodes.data(), nodes[0].near(box)};
  while (true) {
    if (level.near == 0) {
      if (top == 0) return;
      level = stack[--top];
      continue;
    }
    const std::size_t i = child_of(level.near);
    level.near &= level.near - 1;
    const std::uint32_t child = level.node->child(i);
    if (!level.node->is_inner(i)) {
      if (boxes[child].overlaps(box)) visit(items[child], boxes[child]);
      continue;
    }
    if (level.near != 0) stack[top++] = level;
    level = {&nodes[child], nodes[child].near(box)};
  }
}

template <typename Measure, typename Limit, typename Visit>
void TriangleTree::visit_near(const Measure& measure, const Limit& limit, const Visit& visit) const {
  if (nodes.empty()) return;
  struct Entry {
    double distance;
    std::uint32_t index;
    bool is_item;
  };
  Entry stack[(width - 1) * max_depth + 1];
  std::size_t top = 0;
  stack[top++] = {measure(node_boxes[0]), 0, false};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (!(entry.distance <= limit())) continue;
    if (entry.is_item) {
      visit(items[entry.index]);
      continue;
    }
    const Node& node = nodes[entry.index];
    const std::size_t first = top;
    for (std::size_t i = 0; i < node.count; ++i) {
      const std::uint32_t child = node.child(i);
      const bool is_item = !node.is_inner(i);
      const double distance = measure(is_item ? boxes[child] : node_boxes[child]);
      if (!(distance <= limit())) continue;
      // The farthest lowest; of equals the first is the next.
      std::size_t k = top++;
      for (; k > first && stack[k - 1].distance <= distance; --k) stack[k] = stack[k - 1];
      stack[k] = {distance, child, is_item};
    }
  }
}

}  // namespace atl::collision
