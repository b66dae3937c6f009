#pragma once

#include <collision/aabb_tree_node.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::collision {

/// An item and its box, to build a tree from.
struct AabbTreeLeaf {
  Aabb box;
  std::uint32_t item;
};

/// Builds the nodes of a tree over leaves. Keeps its buffers, so that another build allocates nothing.
///
/// The leaves are sorted by the Morton codes of their centres, 21 bits an axis, and split where the highest bit
/// differs (Lauterbach et al., "Fast BVH Construction on GPUs", 2009), but in the middle where the height would
/// exceed 40. Leaves far from all others don't make the grid any coarser. Takes O(n).
class AabbTreeBuilder {
 public:
  /// To be filled in before a build, in any order.
  std::vector<AabbTreeLeaf> leaves;

  /// Replaces the nodes; depth first, so that node 0 is the root and a node's number is below its children's.
  /// Sets the slot, 2 * node + side, of each item; `slots` must be long enough. No leaves make no nodes.
  void build(std::vector<AabbTreeNode>& nodes, std::vector<std::int32_t>& slots);

 private:
  struct Code {
    std::uint64_t code;
    std::uint32_t leaf;
  };

  void sort_codes();
  Aabb build_node(std::size_t begin, std::size_t end, std::int32_t parent, int levels_left);
  Aabb build_child(std::size_t begin, std::size_t end, std::int32_t slot, int levels_left);
  std::size_t split(std::size_t begin, std::size_t end, int levels_left) const;

  std::vector<Code> codes_;
  std::vector<Code> sorted_;
  std::vector<AabbTreeNode>* nodes_ = nullptr;  // during a build
  std::vector<std::int32_t>* slots_ = nullptr;
};

}  // namespace atl::collision
