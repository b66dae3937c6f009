#pragma once

#include <jobs/append.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace atl {

/// The bodies that may move in a step: dynamic ones that are awake, and kinematic ones with a velocity. All that a step
/// does to bodies, it does to these, so that what rests costs nothing.
class ActiveBodies {
 public:
  /// For a world of so many bodies; new ones are not active.
  void resize(std::size_t count) { jobs::append(active_, count, std::uint8_t{0}); }
  bool contains(std::uint32_t body) const { return active_[body] != 0; }
  std::span<const std::uint32_t> in_order() const { return bodies_; }

  /// Asks may_move(body) of bodies for which it may have changed, named in any order and any number of times. Returns
  /// whether it has for some.
  template <typename MayMove>
  bool update(std::span<const std::uint32_t> bodies, const MayMove& may_move);

  /// By the last update, in order.
  std::span<const std::uint32_t> started() const { return started_; }
  std::span<const std::uint32_t> stopped() const { return stopped_; }
  auto arrays() const { return std::tie(active_, bodies_, started_, stopped_); }

 private:
  void apply_changes();

  jobs::CompactArray<std::uint8_t> active_;    // by body
  jobs::CompactArray<std::uint32_t> bodies_;   // in order
  jobs::CompactArray<std::uint32_t> started_;  // in order
  jobs::CompactArray<std::uint32_t> stopped_;  // in order
};

template <typename MayMove>
bool ActiveBodies::update(std::span<const std::uint32_t> bodies, const MayMove& may_move) {
  started_.clear();
  stopped_.clear();
  for (const std::uint32_t body : bodies) {
    const bool moves = may_move(body);
    if (moves == contains(body)) continue;
    active_[body] = moves;
    (moves ? started_ : stopped_).push_back(body);
  }
  if (started_.empty() && stopped_.empty()) return false;
  apply_changes();
  return true;
}

}  // namespace atl
