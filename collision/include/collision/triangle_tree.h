#pragma once

#include <collision/aabb.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Static tree of boxes over the triangles of a surface, laid out in depth-first order, so that a query runs
/// through it without a stack: into a node that overlaps, past the subtree of one that doesn't.
struct TriangleTree {
  struct Node {
    Aabb box;
    std::uint32_t skip;  ///< index of the node after this one's subtree
    std::uint32_t item;  ///< triangle, of a leaf; no_item else
  };
  static constexpr std::uint32_t no_item = ~0u;
  std::vector<Node> nodes;

  /// Splits by the surface area heuristic in bins along the longest axis of the centres (Wald, "On fast
  /// construction of SAH-based bounding volume hierarchies", 2007); one triangle a leaf.
  void build(std::span<const Aabb> boxes);

  /// Calls visit(triangle) for every triangle whose box overlaps, in the tree's order.
  template <typename Visit>
  void query(const Aabb& box, const Visit& visit) const {
    for (std::size_t i = 0; i < nodes.size();) {
      const Node& node = nodes[i];
      const bool hit = node.box.overlaps(box);
      if (hit && node.item != no_item) visit(node.item);
      i = hit ? i + 1 : node.skip;
    }
  }
};

}  // namespace atl::collision
