#pragma once

#include <collision/broadphase/broadphase.h>
#include <collision/shapes/collider_table.h>
#include <collision/shapes/motion_bounds.h>
#include <jobs/arena.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// The motion of bodies and their colliders, from which the AABBs are updated.
struct BodyMotions {
  const ColliderTable& colliders;
  PoseView poses;                    ///< of bodies
  const double* velocities;          ///< 3 a body, m/s
  const double* angular_velocities;  ///< 3 a body, rad/s
  std::span<const double> radius;    ///< by body: m, of its shapes about its centre of mass; 0 where unbounded
  double dt;                         ///< s, the step

  Bounds bounds_at(std::uint32_t collider, const Pose& pose) const;
  Bounds bounds_now(std::uint32_t collider) const { return bounds_at(collider, colliders.pose(collider, poses)); }
  Plane plane_now(std::uint32_t half_space) const;
  bool is_finite(std::uint32_t body) const;  ///< its pose
};

/// Keeps the fat AABBs of bodies' colliders in the broadphase: gives them room for motion, and looks only at bodies
/// that may have used it up, so that the cost follows motion.
class BodyAabbs {
 public:
  MotionBounds bounds;  ///< whoever moves a body spends its margins

  void resize(std::size_t bodies);
  void clear();  ///< of all bodies

  /// m, of fat AABBs along the motion of a body; 0 where it isn't worth mentioning. Part of a world's state.
  const jobs::CompactArray<double>& swept_margins() const { return swept_margins_; }
  jobs::CompactArray<double>& swept_margins() { return swept_margins_; }
  /// Lists the bodies with swept margins, after these were restored.
  void list_swept();

  /// When continuous collision is done for a body.
  enum class Sweep : std::uint8_t { Never, IfFast, Always };
  /// Sets `margin_limit` and `sweep_distance` of a new body by the sizes of its shapes. Returns their radius about its
  /// centre of mass, m.
  double set_limits(std::uint32_t body, Sweep sweep, const BodyMotions& motions);

  /// Puts the colliders of a body that has none there into the broadphase. `fixed`: it can't move.
  void add(std::uint32_t body, bool fixed, const Filter& filter, const BodyMotions& motions, Broadphase& broadphase);
  void remove(std::uint32_t body, const ColliderTable& colliders, Broadphase& broadphase);
  /// A body was put elsewhere, or left its fat AABBs. Nothing happens while its pose is not finite.
  void move(std::uint32_t body, const BodyMotions& motions, Broadphase& broadphase);

  void mark_dirty(std::uint32_t body) { bounds.aabb_dirty[body] = 1; }
  void mark_all_dirty();

  /// Updates, at the start of a step, the AABBs of active bodies whose margins may be used up in it. `active` is in
  /// order.
  void update(std::span<const std::uint32_t> active, const BodyMotions& motions, Broadphase& broadphase,
              jobs::Arena& arena);
  /// Updates, at the end of a step, the AABBs of bodies that were pushed farther than their speed predicted, since
  /// queries between steps rely on AABBs.
  void catch_up(std::span<const std::uint32_t> active, const BodyMotions& motions, Broadphase& broadphase,
                jobs::Arena& arena);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(bounds, swept_margins_, swept_); }

 private:
  // The new fat AABB of a collider, and how far (m) its surface may move before the AABB must be checked again.
  struct Update {
    Aabb fat;
    double margin;
    bool is_new;  // it doesn't fit in the one that it has
  };
  // Memory of the thread that steps, while it is at it.
  struct Memory {
    std::vector<std::uint32_t> dirty;          // bodies
    std::vector<std::uint8_t> inside;          // by body of these
    std::vector<std::vector<Update>> updates;  // by chunk of these, in order
  };

  Update look_at(std::uint32_t collider, const Aabb* current, const BodyMotions& motions) const;
  double swept_margin(std::uint32_t body, const BodyMotions& motions) const;
  void add_swept(std::uint32_t body, const BodyMotions& motions);
  void shrink_swept(const BodyMotions& motions, Broadphase& broadphase);

  // Lists the members that last from step to step, then (after the empty comment) scratch. A new member has to be put
  // into one of the two lists, or this doesn't compile.
  static void check_members(BodyAabbs& aabbs) {
    auto& [bounds, swept_margins, /**/ swept] = aabbs;
    static_cast<void>(bounds);
  }

  jobs::CompactArray<double> swept_margins_;  // by body
  jobs::CompactArray<std::uint32_t> swept_;   // bodies with such margins
};

}  // namespace atl::collision
