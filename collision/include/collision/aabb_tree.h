#pragma once

#include <collision/aabb.h>

#include <cstdint>
#include <vector>

namespace atl::collision {

/// Binary tree of boxes over numbered items, for overlap queries. Items can be added, moved and removed one
/// at a time; the tree rebuilds itself from the top after about as many changes as it has items, so it stays
/// good under any motion at an amortised cost a change.
///
/// Insertion descends by least growth of area (Goldsmith and Salmon 1987; Catto, "Dynamic Bounding Volume
/// Hierarchies", GDC 2019). A rebuild splits at the median of the centres along the longest axis. The tree's
/// shape never shows in a result that is sorted.
class AabbTree {
 public:
  static constexpr std::int32_t none = -1;

  /// Adds an item. Returns its leaf, which stays its handle until removed.
  std::int32_t insert(std::uint32_t item, const Aabb& box);
  void remove(std::int32_t leaf);
  /// Gives a leaf a new box.
  void move(std::int32_t leaf, const Aabb& box);
  /// Rebuilds if enough has changed since the last time.
  void rebuild_if_worn();

  std::size_t size() const { return leaf_count_; }

  /// Calls visit(item) for every item whose box overlaps. Safe from several threads at once.
  template <typename Visit>
  void query(const Aabb& box, const Visit& visit) const {
    if (root_ == none) return;
    std::int32_t stack[max_depth];
    int top = 0;
    stack[top++] = root_;
    while (top > 0) {
      const Node& node = nodes_[static_cast<std::size_t>(stack[--top])];
      if (!node.box.overlaps(box)) continue;
      if (node.is_leaf()) {
        visit(node.item);
      } else {
        stack[top++] = node.child[1];
        stack[top++] = node.child[0];
      }
    }
  }

 private:
  // What the traversals' stacks hold. An insertion that makes the tree higher than half of it rebuilds.
  static constexpr int max_depth = 128;

  struct Node {
    Aabb box;
    std::int32_t parent = none;  // next free node, in the free list
    std::int32_t child[2] = {none, none};
    std::uint32_t item = 0;
    std::int32_t height = 0;  // of a leaf: 0

    bool is_leaf() const { return child[0] == none; }
  };

  std::int32_t allocate();
  void release(std::int32_t node);
  std::int32_t best_sibling(const Aabb& box) const;
  void refit(std::int32_t node);
  void rebuild();
  std::int32_t build(std::int32_t* begin, std::int32_t* end, std::int32_t parent);
  Node& at(std::int32_t node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(std::int32_t node) const { return nodes_[static_cast<std::size_t>(node)]; }

  std::vector<Node> nodes_;
  std::vector<std::int32_t> leaves_;  // scratch of a rebuild
  std::int32_t root_ = none;
  std::int32_t free_ = none;
  std::size_t leaf_count_ = 0;
  std::size_t changes_ = 0;  // since the last rebuild
};

}  // namespace atl::collision
