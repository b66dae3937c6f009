#pragma once

#include <collision/broadphase/aabb_tree.h>
#include <collision/broadphase/filter.h>
#include <collision/broadphase/pair_set.h>
#include <collision/shapes/plane.h>
#include <jobs/arena.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Finds the pairs of shapes that come near each other. A shape has a fat box: its bounds, plus where it may
/// get to, plus some slack, so that only a shape that leaves its fat box causes work.
///
/// Moving and fixed shapes live in two trees: fixed ones are never tested against each other. Half-spaces
/// have no box; each is tested against every shape that moved. Filters leave out pairs that may not meet.
/// A shape whose box has a NaN meets no other; infinite bounds are allowed.
///
/// Fixed shapes that are added wait until something asks for them, and are then built into their tree all at once.
/// Queries look at those that wait one by one: before many of them, call take_in().
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
  const Filter& filter(std::uint32_t shape) const { return proxies_[shape].filter; }
  /// Shapes of these two owners don't meet, as of two jointed bodies, until unignored. All of them count as
  /// moved. Owners may be named before they have shapes; the exclusion stays when their shapes go. Calls are
  /// not counted: one unignore undoes any number of ignores.
  void ignore(std::uint32_t owner_a, std::uint32_t owner_b);
  void unignore(std::uint32_t owner_a, std::uint32_t owner_b);
  /// Whether filters and ignored owners let two shapes meet.
  bool allowed(std::uint32_t a, std::uint32_t b) const;

  /// For a state that is restored: whether a shape is there, and to give it a box or a plane as the two above do, but
  /// for what counts as a move. That is told by mark_moved(), which asks for new partners.
  bool contains(std::uint32_t shape) const { return shape < proxies_.size() && proxies_[shape].kind != Kind::Free; }
  void restore_box(std::uint32_t shape, const Aabb& fat);
  void restore_half_space(std::uint32_t shape, const Plane& plane);
  void mark_moved(std::uint32_t shape);

  const Plane& plane(std::uint32_t shape) const { return half_spaces_[half_space_index(shape)].plane; }
  const Aabb& fat_box(std::uint32_t shape) const { return proxies_[shape].fat; }
  bool is_half_space(std::uint32_t shape) const { return proxies_[shape].kind == Kind::HalfSpace; }
  /// Whether a shape got a new fat box or filter (or was added) since the last forget_moves().
  bool has_moved(std::uint32_t shape) const { return (flags_[shape] & moved_flag) != 0; }
  /// Whether two shapes may meet and their fat boxes overlap. Only a pair with a shape that moved can change.
  bool overlap(std::uint32_t a, std::uint32_t b) const;

  /// Builds what waits into the tree, and says whether anything does.
  void take_in(jobs::Arena& arena) { fixed_.take_in(&arena); }
  bool is_behind() const { return fixed_.is_behind(); }

  /// The pairs, in order, that overlap now, contain a shape that moved, and are not in `known`. Valid until
  /// the next call. The cost follows what moved: nothing moved, nothing done.
  std::span<const Pair> find_new_pairs(const PairSet& known, jobs::Arena& arena);
  void forget_moves();
  /// How many shapes moved since then, those that are gone too.
  std::size_t moved_count() const { return moved_.size(); }

  /// Calls visit(shape) for every shape, fixed ones and half-spaces too, whose fat box overlaps this box, in
  /// no particular order (sort what must not depend on the trees' history). Filters don't matter. Safe from
  /// several threads at once, as long as nobody changes the broadphase; allocates nothing. So is query_ray.
  template <typename Visit>
  void query_box(const Aabb& box, const Visit& visit) const {
    for (const HalfSpace& half_space : half_spaces_) {
      if (touches(half_space.plane, box)) visit(half_space.shape);
    }
    fixed_.query(box, visit);
    moving_.query(box, visit);
  }

  /// Calls `double max_t = visit(shape, t_enter)` for every shape whose fat box, or half-space, is touched by a
  /// box of the given half extents that moves along origin + t * direction, 0 <= t <= max_t. Rays work as in
  /// AabbTree::ray_query: the ray is cut off at what a visit returns. First half-spaces, then fixed shapes,
  /// then moving ones, each set roughly from front to back. Returns the last max_t.
  template <typename Visit>
  double query_ray(const Vector3& origin, const Vector3& direction, double max_t, const Visit& visit,
                   const Vector3& half_extents = Vector3::Zero()) const {
    for (const HalfSpace& half_space : half_spaces_) {
      double t_enter = 0;
      if (enters(half_space.plane, origin, direction, max_t, half_extents, t_enter)) {
        max_t = visit(half_space.shape, t_enter);
      }
    }
    max_t = fixed_.ray_query(origin, direction, max_t, visit, half_extents);
    return moving_.ray_query(origin, direction, max_t, visit, half_extents);
  }

  /// Memory held.
  std::size_t bytes() const {
    std::size_t found = jobs::bytes_of(found_);
    for (const std::vector<Pair>& of_chunk : found_) found += jobs::bytes_of(of_chunk);
    return found + jobs::bytes_of(proxies_, flags_, owners_, half_spaces_, moved_, askers_, new_pairs_, sort_scratch_) +
           ignored_.bytes() + moving_.bytes() + fixed_.bytes();
  }

 private:
  enum class Kind : std::uint8_t { Free, Moving, Fixed, HalfSpace };

  // Flags of a shape. One that has moved is in moved_, even if removed since.
  static constexpr std::uint8_t moved_flag = 1;
  // Its filter is not the default one, or its owner ignores another.
  static constexpr std::uint8_t restricted_flag = 2;

  static constexpr std::uint32_t no_shape = ~std::uint32_t{0};

  struct Proxy {
    Aabb fat = Aabb::empty();
    Filter filter;
    Kind kind = Kind::Free;
    // Shapes of the same owner are linked.
    std::uint32_t next_of_owner = no_shape;
    std::uint32_t previous_of_owner = no_shape;
  };

  struct Owner {
    std::uint32_t first_shape = no_shape;
    std::uint32_t ignored_owners = 0;
  };

  struct HalfSpace {
    std::uint32_t shape;
    Plane plane;
  };

  Proxy& claim(std::uint32_t shape, Kind kind, const Filter& filter);
  Owner& owner(std::uint32_t number);
  void link(std::uint32_t shape, const Filter& filter);
  void unlink(std::uint32_t shape);
  void restrict(std::uint32_t shape);
  void mark_shapes_of(std::uint32_t owner);
  AabbTree& tree_of(const Proxy& proxy) { return proxy.kind == Kind::Fixed ? fixed_ : moving_; }
  std::span<const std::uint32_t> list_askers();
  bool ask_fixed(std::span<const std::uint32_t> askers) const;
  std::size_t half_space_index(std::uint32_t shape) const;
  void find_partners(std::uint32_t shape, std::vector<Pair>& found) const;

  std::vector<Proxy> proxies_;          // by shape
  std::vector<std::uint8_t> flags_;     // by shape; apart, as they are all that most candidates are asked for
  std::vector<Owner> owners_;           // by number
  std::vector<HalfSpace> half_spaces_;  // in order of shape
  PairSet ignored_;                     // of owners
  AabbTree moving_;
  AabbTree fixed_;
  std::vector<std::uint32_t> moved_;
  bool moving_ask_ = false;               // of pairs with a fixed shape, the moving one is asked, whichever moved
  std::vector<std::uint32_t> askers_;     // then
  std::vector<std::vector<Pair>> found_;  // by chunk of moved_
  std::vector<Pair> new_pairs_;
  std::vector<Pair> sort_scratch_;
};

}  // namespace atl::collision
