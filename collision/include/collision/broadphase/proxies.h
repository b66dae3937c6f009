#pragma once

#include <collision/broadphase/aabb_tree.h>
#include <collision/shapes/plane.h>
#include <jobs/arena.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstdint>
#include <span>

namespace atl::collision {

/// The shapes as the broadphase sees them: fat boxes of moving shapes in one tree, of fixed shapes in another, and
/// half-spaces, which have no box. A shape whose box has a NaN touches no other; infinite bounds are allowed.
///
/// Shapes that are added wait until something asks for them, and are then built into their tree all at once. Queries
/// test the waiting shapes one by one: call take_in() before many queries.
class Proxies {
 public:
  enum class Kind : std::uint8_t { Free, Moving, Fixed, HalfSpace };

  struct HalfSpace {
    std::uint32_t shape;
    Plane plane;
  };

  /// `shape` numbers the shape, and must be free. A box is fixed if its shape can't move.
  void add_box(std::uint32_t shape, const Aabb& fat, bool fixed);
  void add_half_space(std::uint32_t shape, const Plane& plane);
  void remove(std::uint32_t shape);
  void set_box(std::uint32_t shape, const Aabb& fat);
  void set_plane(std::uint32_t shape, const Plane& plane);

  bool contains(std::uint32_t shape) const { return shape < proxies_.size() && kind(shape) != Kind::Free; }
  Kind kind(std::uint32_t shape) const { return proxies_[shape].kind; }
  bool is_half_space(std::uint32_t shape) const { return kind(shape) == Kind::HalfSpace; }
  const Aabb& fat_box(std::uint32_t shape) const { return proxies_[shape].fat; }
  const Plane& plane(std::uint32_t shape) const { return half_spaces_[half_space_index(shape)].plane; }
  /// True if the fat boxes of two shapes, or a fat box and a half-space, overlap.
  bool overlap(std::uint32_t a, std::uint32_t b) const;

  const AabbTree& moving() const { return moving_; }
  const AabbTree& fixed() const { return fixed_; }
  /// The half-spaces, in order of shape.
  std::span<const HalfSpace> half_spaces() const { return half_spaces_; }

  /// Builds what waits into the trees, and says whether anything does.
  void take_in(jobs::Arena& arena) {
    moving_.take_in(&arena);
    take_in_fixed(arena);
  }
  void take_in_fixed(jobs::Arena& arena) { fixed_.take_in(&arena); }
  bool is_behind() const { return moving_.is_behind() || fixed_.is_behind(); }
  /// Build a tree anew if enough has changed in it, that of what moves with all that waits.
  void renew_moving(jobs::Arena& arena) {
    moving_.take_in(&arena);
    moving_.rebuild_if_worn(&arena);
  }
  void rebuild_fixed_if_worn(jobs::Arena& arena) { fixed_.rebuild_if_worn(&arena); }

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

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(proxies_, half_spaces_, moving_, fixed_); }

 private:
  struct Proxy {
    Aabb fat = Aabb::empty();
    Kind kind = Kind::Free;
  };

  Proxy& claim(std::uint32_t shape, Kind kind);
  AabbTree& tree_of(const Proxy& proxy) { return proxy.kind == Kind::Fixed ? fixed_ : moving_; }
  std::size_t half_space_index(std::uint32_t shape) const;

  jobs::CompactArray<Proxy> proxies_;          // by shape
  jobs::CompactArray<HalfSpace> half_spaces_;  // in order of shape
  AabbTree moving_;
  AabbTree fixed_;
};

}  // namespace atl::collision
