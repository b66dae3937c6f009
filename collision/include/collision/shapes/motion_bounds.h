#pragma once

#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace atl::collision {

/// The distances that bodies may move before their boxes, or their paths, must be checked: one entry a body index. Any
/// code that moves a body calls moved(), so that later checks can skip bodies that haven't moved.
struct MotionBounds {
  jobs::CompactArray<double> aabb_margin;     ///< m that its surface may still move before its AABBs must be looked at
  jobs::CompactArray<double> margin_limit;    ///< m: no more motion in a step than this counts against the margin
  jobs::CompactArray<double> sweep_distance;  ///< m: who moves farther in a step may have passed through something
  jobs::CompactArray<std::uint8_t> aabb_dirty;  ///< 1 if the margin may be used up

  void resize(std::size_t count) {
    for (jobs::CompactArray<double>* values : {&aabb_margin, &margin_limit, &sweep_distance})
      jobs::append(*values, count, 0.0);
    jobs::append(aabb_dirty, count, std::uint8_t{0});
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(aabb_margin, margin_limit, sweep_distance, aabb_dirty); }

  /// A body's surface moved by `distance` (m), and will by `next` (m) in the next step. Returns whether it was fast.
  bool moved(std::uint32_t body, double distance, double next) {
    aabb_margin[body] -= distance;
    // Written so that a body which is no longer finite is looked at, and found out.
    if (!(aabb_margin[body] >= std::min(next, margin_limit[body]))) aabb_dirty[body] = 1;
    return distance > sweep_distance[body];
  }
};

}  // namespace atl::collision
