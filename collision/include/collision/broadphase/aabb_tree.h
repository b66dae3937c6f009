#pragma once

#include <collision/broadphase/aabb_tree_builder.h>
#include <collision/broadphase/ray_slabs.h>
#include <jobs/bytes.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace atl::collision {

/// Binary tree of boxes over numbered items, for overlap and ray queries. Items can be added, moved and
/// removed one at a time; the tree rebuilds itself after about as many changes as it has items, so it stays
/// good under any motion at an amortised cost a change.
///
/// Insertion descends by least growth of area (Goldsmith and Salmon 1987; Catto, "Dynamic Bounding Volume
/// Hierarchies", GDC 2019). A move refits the boxes above. A rebuild sorts the items along a Morton curve
/// (aabb_tree_builder.h). The tree's shape never shows in a result that is sorted.
///
/// Many items that come at once are best told by insert_later(): take_in() then builds the tree of all of them, which
/// takes a tenth of what it takes to insert them one by one.
///
/// Boxes may be infinite. One with a NaN is never found, but may be moved and removed as any other.
class AabbTree {
 public:
  /// Adds an item, which must not be in the tree. Tables have the size of the largest item; items < 2^31 - 1.
  void insert(std::uint32_t item, const Aabb& box);
  /// The same, but that until take_in() queries look at it one by one. It may be moved and removed as any other.
  void insert_later(std::uint32_t item, const Aabb& box);
  /// Without an arena this thread builds all of it.
  void take_in(jobs::Arena* arena = nullptr);
  /// Whether there is anything to take in, and whether an item is.
  bool is_behind() const { return !later_.empty(); }
  bool is_later(std::uint32_t item) const { return slots_[item] < 0; }
  void remove(std::uint32_t item);
  /// Gives an item a new box.
  void move(std::uint32_t item, const Aabb& box);
  /// Rebuilds if enough has changed since the last time.
  void rebuild_if_worn(jobs::Arena* arena = nullptr);

  /// Items, those that are to be taken in, too.
  std::size_t size() const { return size_ + later_.size(); }
  /// Memory held.
  std::size_t bytes() const { return jobs::bytes_of(nodes_, slots_, later_) + builder_.bytes(); }
  /// Where in the tree an item is. After a rebuild, items near each other have places near each other.
  std::uint32_t place(std::uint32_t item) const { return static_cast<std::uint32_t>(slots_[item]); }

  /// Calls visit(item) for every item whose box overlaps. Safe from several threads at once.
  template <typename Visit>
  void query(const Aabb& box, const Visit& visit) const {
    traverse([probe = Node::Probe(box)](const Node& node) { return node.overlaps(probe); }, visit);
    for (const AabbTreeLeaf& leaf : later_) {
      if (leaf.box.overlaps(box)) visit(leaf.item);
    }
  }

  /// Calls visit(item) for every item, in no order to rely on.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (const Node& node : nodes_) {
      for (const std::int32_t child : node.child) {
        if (Node::is_leaf(child)) visit(item_of(child));
      }
    }
    for (const AabbTreeLeaf& leaf : later_) visit(leaf.item);
  }

  /// Calls visit(item) for every item whose box passes test(box); test must accept a box that is around one
  /// that it accepts.
  template <typename Test, typename Visit>
  void query_if(const Test& test, const Visit& visit) const {
    const auto hits = [&](const Node& node) {
      const bool first = node.child[0] != Node::none && test(node.box(0));
      const bool second = node.child[1] != Node::none && test(node.box(1));
      return unsigned{first} | unsigned{second} << 1;
    };
    traverse(hits, visit);
    for (const AabbTreeLeaf& leaf : later_) {
      if (test(leaf.box)) visit(leaf.item);
    }
  }

  /// Visits the items whose boxes a ray touches, roughly from front to back, as
  /// `double max_t = visit(item, t_enter)`: the ray is cut off at what it returns (give back the old max_t to
  /// go on, a negative number to stop). t_enter is where the ray enters the box, rounded down, or 0 if it starts
  /// inside. Boxes are grown by half_extents on all sides, for sweeping a box. Never misses a box by rounding.
  /// Items are not strictly ordered by t_enter, and the order depends on the tree's shape: of equal hits choose
  /// by item. Safe from several threads at once. Returns the last max_t.
  template <typename Visit>
  double ray_query(const Vector3& origin, const Vector3& direction, double max_t, const Visit& visit,
                   const Vector3& half_extents = Vector3::Zero()) const {
    struct Entry {
      std::int32_t child;
      double t_enter;
    };
    const RaySlabs ray(origin, direction, max_t, half_extents);
    if (!ray.valid()) return max_t;
    for (const AabbTreeLeaf& leaf : later_) {
      double t_enter = 0;
      if (ray.enter(leaf.box, max_t, t_enter)) max_t = visit(leaf.item, t_enter);
    }
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
  using Node = AabbTreeNode;

  // What the traversals' stacks need. A change that makes the tree higher rebuilds it.
  static constexpr int max_height = 128;

  static std::uint32_t item_of(std::int32_t leaf) { return ~static_cast<std::uint32_t>(leaf); }
  static std::int32_t leaf_of(std::uint32_t item) { return static_cast<std::int32_t>(~item); }

  // Depth first into the children for which hits(node) has a bit.
  template <typename Hits, typename Visit>
  void traverse(const Hits& hits, const Visit& visit) const {
    if (root_ == Node::none) return;
    // No branch depends on a hit, as none could be predicted: a child is always written, and counted if hit.
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

  std::int32_t allocate();
  void release(std::int32_t node);
  std::int32_t best_slot(const Aabb& box) const;
  void put(std::int32_t slot, std::int32_t child, const Aabb& box);
  std::int32_t height_of(std::int32_t child) const;
  void update_height(std::int32_t node);
  void balance(std::int32_t node);
  void refit(std::int32_t node);
  void refit_boxes(std::int32_t node);
  void rebuild(jobs::Arena* arena);
  Node& at(std::int32_t node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(std::int32_t node) const { return nodes_[static_cast<std::size_t>(node)]; }

  std::vector<Node> nodes_;          // those that are free have no children
  std::vector<std::int32_t> slots_;  // by item: 2 * node + side, or ~ its place in later_
  std::vector<AabbTreeLeaf> later_;  // in no order
  AabbTreeBuilder builder_;
  std::int32_t root_ = Node::none;
  std::int32_t free_ = Node::none;
  std::size_t size_ = 0;     // of what is in the nodes
  std::size_t changes_ = 0;  // since the last rebuild
};

}  // namespace atl::collision
