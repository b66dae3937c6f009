#pragma once

#include <collision/broadphase/aabb_tree_node.h>
#include <jobs/arena.h>
#include <jobs/arrays.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
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
///
/// Many leaves are built by all workers of an arena: codes are sorted by their highest digit first and then digit by
/// digit within a bucket, and as a subtree of n leaves has n - 1 nodes, it is known ahead where each goes. So the tree
/// is the same on any number of threads.
class AabbTreeBuilder {
 public:
  /// The leaves, filled in before a build, in any order.
  std::vector<AabbTreeLeaf> leaves;

  /// Replaces the nodes; depth first, so that node 0 is the root and a node's number is below its children's.
  /// Sets the slot, 2 * node + side, of each item; `slots` must be long enough. No leaves make no nodes. Without an
  /// arena this thread builds all of it.
  void build(jobs::CompactArray<AabbTreeNode>& nodes, jobs::CompactArray<std::int32_t>& slots, jobs::Arena* arena);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(leaves, codes_, sorted_, chunks_, divided_, parts_, above_); }

 private:
  struct Code {
    std::uint64_t code;
    std::uint32_t leaf;
  };

  static constexpr int digit_bits = 8;
  static constexpr std::size_t digit_values = 1 << digit_bits;

  // The interval of finite box centres along an axis, m. The numbers are twice the centres (lower + upper of a box).
  struct Range {
    double lower = std::numeric_limits<double>::infinity();
    double upper = -std::numeric_limits<double>::infinity();
  };

  // The result of one chunk of a parallel loop over leaves.
  struct Chunk {
    std::array<Range, 3> ranges;
    std::uint64_t differing;                         // bits in which its codes differ from the first
    std::array<std::uint32_t, digit_values> places;  // by digit: where the next of its codes goes
  };

  // A subtree that is to be built: its codes, the number of its root, and where that hangs.
  struct Part {
    std::size_t begin;
    std::size_t end;
    std::size_t number;
    std::int32_t parent;
    int levels_left;
  };

  // Cubic cells of a grid that most centres are in; what is outside counts to the cells at its faces.
  struct Grid {
    std::array<double, 3> origin;
    double cells_per_unit;
  };

  template <typename Body>
  void for_leaves(const Body& body) const;
  Grid grid_around_leaves();
  void find_codes();
  void sort_codes();
  void sort_bucket(std::size_t begin, std::size_t end);
  void divide();
  Aabb build_node(const Part& part);
  Aabb build_child(const Part& part, int side, std::size_t middle);
  void join(std::size_t number);
  Part child_of(const Part& part, int side, std::size_t middle) const;
  std::size_t split(const Part& part) const;

  std::vector<Code> codes_;
  std::vector<Code> sorted_;
  std::vector<Chunk> chunks_;
  std::vector<Part> divided_;
  std::vector<Part> parts_;         // of a tree that is built in several
  std::vector<std::size_t> above_;  // the nodes above these, parents first
  // During a build.
  jobs::CompactArray<AabbTreeNode>* nodes_ = nullptr;
  jobs::CompactArray<std::int32_t>* slots_ = nullptr;
  jobs::Arena* arena_ = nullptr;
};

}  // namespace atl::collision
