#pragma once

#include <collision/aabb_tree.h>
#include <collision/pair_set.h>
#include <jobs/arena.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Solid where normal . p <= offset, in the world frame.
struct Plane {
  Vector3 normal;
  double offset;
};

/// Finds the pairs of shapes that come near each other. A shape has a fat box: its bounds, plus where it may
/// get to, plus some slack, so that only a shape that leaves its fat box causes work.
///
/// Moving and fixed shapes live in two trees: fixed ones are never tested against each other. Half-spaces
/// have no box; each is tested against every shape that moved.
class Broadphase {
 public:
  /// `shape` numbers the shape, and must be free. A box is fixed if its shape can't move.
  void add_box(std::uint32_t shape, const Aabb& fat, bool fixed);
  void add_half_space(std::uint32_t shape, const Plane& plane);
  void remove(std::uint32_t shape);

  /// Gives a shape a new fat box, or a half-space a new plane. It will be asked for new partners.
  void move_box(std::uint32_t shape, const Aabb& fat);
  void move_half_space(std::uint32_t shape, const Plane& plane);

  const Aabb& fat_box(std::uint32_t shape) const { return proxies_[shape].fat; }
  bool is_half_space(std::uint32_t shape) const { return proxies_[shape].kind == Kind::HalfSpace; }
  /// Whether a shape got a new fat box (or was added) since the last forget_moves().
  bool has_moved(std::uint32_t shape) const { return proxies_[shape].moved; }
  bool overlap(std::uint32_t a, std::uint32_t b) const;

  /// The pairs, in order, that overlap now, contain a shape that moved, and are not in `known`. Valid until
  /// the next call.
  std::span<const Pair> find_new_pairs(const PairSet& known, jobs::Arena& arena);
  void forget_moves();

 private:
  enum class Kind : std::uint8_t { Free, Moving, Fixed, HalfSpace };

  struct Proxy {
    Aabb fat = Aabb::empty();
    std::int32_t leaf = AabbTree::none;
    Kind kind = Kind::Free;
    bool moved = false;
  };

  struct HalfSpace {
    std::uint32_t shape;
    Plane plane;
  };

  Proxy& claim(std::uint32_t shape, Kind kind);
  void mark_moved(std::uint32_t shape);
  std::size_t half_space_index(std::uint32_t shape) const;
  static bool touches(const Plane& plane, const Aabb& box);
  void query(std::uint32_t shape, const PairSet& known, std::vector<Pair>& found) const;

  std::vector<Proxy> proxies_;          // by shape
  std::vector<HalfSpace> half_spaces_;  // in order of shape
  AabbTree moving_;
  AabbTree fixed_;
  std::vector<std::uint32_t> moved_;
  std::vector<std::vector<Pair>> found_;  // by chunk of moved_
  std::vector<Pair> new_pairs_;
};

}  // namespace atl::collision
