#pragma once

#include <collision/contacts/update_contacts.h>

#include <cstdint>
#include <span>

#include "step/step_context.h"
#include "world/stores.h"

namespace atl {

/// Moved AABBs -> new pairs, in order of ids.
void find_pairs(Stores& world, const StepContext& step);

/// Finds out where the points of contacts are that steps leave alone, as both their bodies rest: for callers that ask.
void place_idle_contacts(Stores& world, const collision::NarrowphaseKernels& kernels, jobs::Arena& arena);

/// Pairs -> manifolds: they are kept, refreshed, or FCL is asked.
class ContactPhase {
 public:
  void update(Stores& world, const StepContext& step);
  /// Contacts of bodies that were just woken count with the features they fell asleep with.
  void add_woken(Stores& world, const StepContext& step, std::span<const std::uint32_t> slots);
  void remove_lost(Stores& world) const;
  /// The next update starts afresh: the world is another.
  void forget() { update_.forget(); }

  /// In order. Valid until the next update.
  std::span<const solver::TouchingPair> touching() const { return update_.touching; }
  bool touching_changed() const { return update_.touching_changed; }
  std::int64_t points() const { return update_.counts.points; }
  std::size_t bytes() const { return update_.bytes(); }

 private:
  collision::ContactUpdate update_;
};

}  // namespace atl
