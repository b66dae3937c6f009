#pragma once

#include <collision/broadphase/collision_filters.h>
#include <collision/broadphase/move_buffer.h>
#include <collision/broadphase/pair_set.h>
#include <collision/broadphase/proxies.h>
#include <jobs/arena.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Looks for new pairs among the proxies, and keeps the memory that this takes: of a thread, for all worlds that it
/// steps. The cost follows what moved.
class PairSearch {
 public:
  /// The pairs, in order, that overlap, may meet, contain a shape that moved, and are not in `known`. Valid until the
  /// next call. Brings the trees of the proxies into shape before it asks them, if enough is asked for that to pay:
  /// `looks` tells how often those that ask have looked at fixed shapes that wait, one by one.
  std::span<const Pair> find(Proxies& proxies, const CollisionFilters& filters, const MoveBuffer& moves,
                             const PairSet& known, std::size_t& looks, jobs::Arena& arena);

 private:
  void list_askers(const Proxies& proxies, std::span<const std::uint32_t> moved);

  std::vector<std::uint32_t> askers_;     // the moving shapes, if they ask for fixed ones
  std::vector<std::vector<Pair>> found_;  // by chunk of those that ask
  std::vector<Pair> new_pairs_;
  std::vector<Pair> sort_scratch_;
};

}  // namespace atl::collision
