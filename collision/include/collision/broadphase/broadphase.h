#pragma once

#include <collision/broadphase/collision_filters.h>
#include <collision/broadphase/move_buffer.h>
#include <collision/broadphase/pair_search.h>
#include <collision/broadphase/proxies.h>
#include <jobs/scratch.h>

#include <cstdint>
#include <span>

namespace atl::collision {

/// Finds the pairs of shapes that come near each other. A shape has a fat box: its bounds, plus where it may
/// get to, plus a margin, so that only a shape that leaves its fat box causes work.
///
/// proxies() says where shapes are, filters() which of them may meet. Every change of either goes through here, so that
/// shapes which it touches are asked for new partners. Fixed shapes and half-spaces are never tested against each
/// other; each half-space is tested against every shape that moved.
class Broadphase {
 public:
  /// `shape` numbers the shape, and must be free; the owner is the shape itself if the filter names none.
  /// A box is fixed if its shape can't move.
  void add_box(std::uint32_t shape, const Aabb& fat, bool fixed, const Filter& filter = {});
  void add_half_space(std::uint32_t shape, const Plane& plane, const Filter& filter = {});
  void remove(std::uint32_t shape);

  /// Gives a shape a new fat box, or a half-space a new plane. It will be asked for new partners.
  void move_box(std::uint32_t shape, const Aabb& fat);
  void move_half_space(std::uint32_t shape, const Plane& plane);

  /// Gives a shape a new filter. It counts as moved: pairs that may meet now are found, others don't overlap.
  void set_filter(std::uint32_t shape, const Filter& filter);
  /// Shapes of these two owners don't meet, as of two jointed bodies, until their pair is enabled. All of them count as
  /// moved. Owners may be named before they have shapes; a disabled pair stays when their shapes go. Calls are
  /// not counted: one enable_pair() undoes any number of disable_pair().
  void disable_pair(std::uint32_t owner_a, std::uint32_t owner_b);
  void enable_pair(std::uint32_t owner_a, std::uint32_t owner_b);

  /// Restore a saved state: give a shape its box or plane as the two functions above do, but without marking it as
  /// moved. mark_moved() marks it, so that the next search looks for its new partners.
  void restore_box(std::uint32_t shape, const Aabb& fat) { proxies_.set_box(shape, fat); }
  void restore_half_space(std::uint32_t shape, const Plane& plane) { proxies_.set_plane(shape, plane); }
  void mark_moved(std::uint32_t shape) { moves_.mark(shape); }

  const Proxies& proxies() const { return proxies_; }
  const CollisionFilters& filters() const { return filters_; }
  /// True if a shape was added, or got a new fat box or filter, since the last forget_moves().
  bool has_moved(std::uint32_t shape) const { return moves_.contains(shape); }
  /// True if two shapes may meet and their fat boxes overlap. The answer changes only for pairs with a shape that
  /// moved.
  bool overlap(std::uint32_t a, std::uint32_t b) const { return filters_.allowed(a, b) && proxies_.overlap(a, b); }

  /// Builds the fixed shapes that wait into their tree, and says whether any do.
  void take_in(jobs::Arena& arena) { proxies_.take_in(arena); }
  bool is_behind() const { return proxies_.is_behind(); }

  /// The pairs, in order, that overlap now, contain a shape that moved, and are not in `known`. Valid until
  /// this thread's next call. The cost follows what moved: nothing moved, nothing done.
  std::span<const Pair> find_new_pairs(const PairSet& known, jobs::Arena& arena) {
    return jobs::of_this_thread<PairSearch>().find(proxies_, filters_, moves_, known, looks_, arena);
  }
  void forget_moves() { moves_.clear(); }
  /// The number of shapes that moved since then, including removed ones.
  std::size_t moved_count() const { return moves_.shapes().size(); }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(proxies_, filters_, moves_); }

 private:
  void begin(std::uint32_t shape, const Filter& filter);
  void mark_shapes_of(std::uint32_t owner);

  // Lists the members that last from step to step, then (after the empty comment) scratch. A new member has to be put
  // into one of the two lists, or this doesn't compile.
  static void check_members(Broadphase& broadphase) {
    auto& [proxies, filters, moves, /**/ looks] = broadphase;
    static_cast<void>(proxies);
  }

  Proxies proxies_;
  CollisionFilters filters_;
  MoveBuffer moves_;
  std::size_t looks_ = 0;  // see PairSearch
};

}  // namespace atl::collision
