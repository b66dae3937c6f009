#pragma once

#include <collision/broadphase/aabb_tree_builder.h>
#include <collision/broadphase/ray_slabs.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace atl::collision {

/// The nodes of an AabbTree, linked, and where each item hangs. One item at a time comes, goes or gets another box, and
/// the boxes above follow.
///
/// Insertion descends by least growth of area (Goldsmith and Salmon 1987; Catto, "Dynamic Bounding Volume
/// Hierarchies", GDC 2019).
class AabbTreeNodes {
 public:
  using Node = AabbTreeNode;

  /// The height that the stacks of traversals have room for. A higher tree has to be rebuilt before it is traversed.
  static constexpr int max_height = 128;

  void insert(std::uint32_t item, const Aabb& box);
  void remove(std::uint32_t item);
  void set_box(std::uint32_t item, const Aabb& box);
  /// Builds all of it anew from the builder's leaves and its own.
  void rebuild(AabbTreeBuilder& builder, jobs::Arena* arena);

  std::size_t size() const { return size_; }  ///< items
  bool is_too_high() const { return root_ != Node::none && at(root_).height >= max_height; }
  Aabb box(std::uint32_t item) const { return at(slots_[item] / 2).box(slots_[item] % 2); }
  auto arrays() const { return std::tie(nodes_, slots_); }

  /// The slot of an item, 2 * node + side. An item without a node has a number below 0, free for its owner's use.
  std::int32_t slot(std::uint32_t item) const { return slots_[item]; }
  void set_aside(std::uint32_t item, std::int32_t number);

  /// Calls visit(item) depth first for the children for which hits(node) has a bit.
  template <typename Hits, typename Visit>
  void traverse(const Hits& hits, const Visit& visit) const {
    if (root_ == Node::none) return;
    // No branch depends on a hit, since hits can't be predicted: a child is always written, and counted only if hit.
    constexpr int batch = 64;
    std::int32_t stack[max_height + 1];
    std::int32_t found[batch + 2];
    int top = 0;
    int count = 0;
    stack[top++] = root_;
    while (top > 0) {
      const Node& node = at(stack[--top]);
      const unsigned hit = hits(node);
      for (const int side : {1, 0}) {
        const std::int32_t child = node.child[side];
        const int here = static_cast<int>(hit >> side & 1);
        const int inner = static_cast<int>(Node::is_node(child));
        stack[top] = child;
        top += here & inner;
        found[count] = child;
        count += here & ~inner;
      }
      if (count < batch) continue;
      for (int i = 0; i < count; ++i) visit(item_of(found[i]));
      count = 0;
    }
    for (int i = 0; i < count; ++i) visit(item_of(found[i]));
  }

  /// Calls visit(item) for every item, in no order to rely on.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (const Node& node : nodes_) {
      for (const std::int32_t child : node.child) {
        if (Node::is_leaf(child)) visit(item_of(child));
      }
    }
  }

  /// Does the work of AabbTree::ray_query().
  template <typename Visit>
  double follow_ray(const RaySlabs& ray, double max_t, const Visit& visit) const {
    struct Entry {
      std::int32_t child;
      double t_enter;
    };
    if (root_ == Node::none) return max_t;
    Entry stack[max_height];
    int top = 0;
    stack[top++] = {root_, 0};
    while (top > 0) {
      const Entry entry = stack[--top];
      if (entry.t_enter > max_t) continue;
      if (Node::is_leaf(entry.child)) {
        max_t = visit(item_of(entry.child), entry.t_enter);
        continue;
      }
      const Node& node = at(entry.child);
      Entry near{node.child[0], 0};
      Entry far{node.child[1], 0};
      bool hits_near = ray.enter(node.box(0), max_t, near.t_enter);
      bool hits_far = ray.enter(node.box(1), max_t, far.t_enter);
      if (far.t_enter < near.t_enter) {
        std::swap(near, far);
        std::swap(hits_near, hits_far);
      }
      if (hits_far) stack[top++] = far;
      if (hits_near) stack[top++] = near;
    }
    return max_t;
  }

 private:
  static std::uint32_t item_of(std::int32_t leaf) { return ~static_cast<std::uint32_t>(leaf); }
  static std::int32_t leaf_of(std::uint32_t item) { return static_cast<std::int32_t>(~item); }

  std::int32_t allocate();
  void release(std::int32_t node);
  std::int32_t best_slot(const Aabb& box) const;
  void put(std::int32_t slot, std::int32_t child, const Aabb& box);
  std::int32_t height_of(std::int32_t child) const;
  void update_height(std::int32_t node);
  void balance(std::int32_t node);
  void refit(std::int32_t node);
  Node& at(std::int32_t node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(std::int32_t node) const { return nodes_[static_cast<std::size_t>(node)]; }

  jobs::CompactArray<Node> nodes_;          // free nodes have no children
  jobs::CompactArray<std::int32_t> slots_;  // by item
  std::int32_t root_ = Node::none;
  std::int32_t free_ = Node::none;
  std::size_t size_ = 0;
};

}  // namespace atl::collision
