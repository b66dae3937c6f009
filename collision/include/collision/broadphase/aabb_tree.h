#pragma once

#include <collision/broadphase/aabb_tree_nodes.h>
#include <jobs/arrays.h>

#include <cstdint>
#include <vector>

namespace atl::collision {

/// Binary tree of boxes over numbered items, for overlap and ray queries. Items can be added, moved and
/// removed one at a time; the tree rebuilds itself after about as many changes as it has items, so it stays
/// good under any motion at an amortised cost a change.
///
/// A move refits the boxes above (aabb_tree_nodes.h). A rebuild sorts the items along a Morton curve
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
  /// Tell if any item waits to be built into the tree, and if a given item does.
  bool is_behind() const { return !later_.empty(); }
  bool is_later(std::uint32_t item) const { return nodes_.slot(item) < 0; }
  void remove(std::uint32_t item);
  /// Gives an item a new box.
  void move(std::uint32_t item, const Aabb& box);
  /// Rebuilds if enough has changed since the last time.
  void rebuild_if_worn(jobs::Arena* arena = nullptr);

  /// Items, those that are to be taken in, too.
  std::size_t size() const { return nodes_.size() + later_.size(); }
  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(nodes_, later_, builder_); }
  /// The item's slot in the tree. After a rebuild, items close to each other in space have close slots.
  std::uint32_t place(std::uint32_t item) const { return static_cast<std::uint32_t>(nodes_.slot(item)); }

  /// Calls visit(item) for every item whose box overlaps. Safe from several threads at once.
  template <typename Visit>
  void query(const Aabb& box, const Visit& visit) const {
    nodes_.traverse([probe = Node::Probe(box)](const Node& node) { return node.overlaps(probe); }, visit);
    for (const AabbTreeLeaf& leaf : later_) {
      if (leaf.box.overlaps(box)) visit(leaf.item);
    }
  }

  /// Calls visit(item) for every item, in no order to rely on.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    nodes_.for_each(visit);
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
    nodes_.traverse(hits, visit);
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
    const RaySlabs ray(origin, direction, max_t, half_extents);
    if (!ray.valid()) return max_t;
    for (const AabbTreeLeaf& leaf : later_) {
      double t_enter = 0;
      if (ray.enter(leaf.box, max_t, t_enter)) max_t = visit(leaf.item, t_enter);
    }
    return nodes_.follow_ray(ray, max_t, visit);
  }

 private:
  using Node = AabbTreeNode;

  void rebuild(std::vector<AabbTreeLeaf> leaves, jobs::Arena* arena);
  AabbTreeLeaf& waiting(std::int32_t slot) { return later_[~static_cast<std::uint32_t>(slot)]; }

  AabbTreeNodes nodes_;
  std::vector<AabbTreeLeaf> later_;       // in no order; their numbers with the nodes are ~ their places here
  std::vector<AabbTreeBuilder> builder_;  // one if the tree is large
  std::size_t changes_ = 0;               // since the last rebuild
};

}  // namespace atl::collision
