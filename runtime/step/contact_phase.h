#pragma once

#include <collision/contacts/inner_edges.h>
#include <collision/contacts/update_contacts.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <solver/constraints/surface_contact.h>

#include <cstdint>
#include <span>

#include "step/contact_rules.h"
#include "step/step_context.h"
#include "world/stores.h"

namespace atl {

/// Moved AABBs -> new pairs, in order of ids.
void find_pairs(Stores& world, const StepContext& step);

/// Finds out where the points of contacts are that steps leave alone, as both their bodies rest: for callers that ask.
void place_idle_contacts(Stores& world, const collision::NarrowphaseKernels& kernels, jobs::Arena& arena);

/// Pairs -> manifolds: they are kept, refreshed, or FCL is asked. A modifier has its say of those that touch.
class ContactPhase {
 public:
  void update(Stores& world, const StepContext& step);
  /// Contacts of bodies that were just woken count with the features they fell asleep with.
  void add_woken(Stores& world, const StepContext& step, std::span<const std::uint32_t> slots);
  /// Removes the contacts of pairs that came apart; no others go before the step ends.
  void remove_lost(Stores& world);
  /// The next update starts afresh: the world is another.
  void forget() {
    update_.forget();
    cache_changes_ = ~std::uint64_t{0};
  }

  /// In order, but for those at edges that are none, and those that a modifier switched off. Valid until the next
  /// update.
  std::span<const solver::TouchingPair> touching() const {
    return off_.empty() ? std::span(update_.touching) : std::span(on_);
  }
  /// True while touching() still lists all contacts with points: none came, went, or is idle.
  bool touching_is_all(const Stores& world) const {
    return world.cache.changes() == cache_changes_ && world.cache.order().size() == world.cache.size();
  }
  bool touching_changed() const { return update_.touching_changed || off_changed_; }
  /// True if a modifier gave friction or restitution to other contacts than in the last step, or took it from others.
  bool kinds_changed() const { return other_kinds_ != other_kinds_before_; }
  std::int64_t points() const { return update_.counts.points - modified_.points_off - inner_points_; }
  /// Pairs of colliders of which all contacts are switched off, in order.
  std::span<const collision::Pair> pairs_off() const { return modified_.pairs_off; }
  /// The slip that a modifier adds to contacts, by slot; null if it adds none.
  const solver::AddedSlip* added_slips() const { return modified_.slips ? slips_.data() : nullptr; }
  auto arrays() const { return std::tie(update_, inner_edges_, inner_, off_, on_, slips_, other_kinds_); }

 private:
  // The changes that a modifier made to the step's contacts.
  struct Modified {
    jobs::CompactArray<std::uint32_t> off;          // slots, in order
    jobs::CompactArray<collision::Pair> pairs_off;  // in order
    std::int64_t points_off = 0;
    bool slips = false;
  };

  void leave_out_inner_edges(Stores& world, const collision::NarrowphaseKernels& kernels);
  void modify(Stores& world, const StepContext& step, std::span<const solver::TouchingPair> contacts);
  void change(Stores& world, std::uint32_t slot, const ModifiedContact& modified);
  void list_on(const Stores& world);
  void mix_surfaces(Stores& world);

  collision::ContactUpdate update_;
  collision::InnerEdges inner_edges_;
  std::int64_t inner_points_ = 0;
  Modified modified_;
  jobs::CompactArray<std::uint32_t> inner_, off_;  // slots, in order; the latter are all that are left out
  jobs::CompactArray<solver::TouchingPair> on_;    // where some are
  // By pair and part: slots go over to others as contacts come and go.
  using Part = std::pair<collision::Pair, std::uint8_t>;
  jobs::CompactArray<Part> parts_off_, parts_off_before_;  // in order
  // By part, contacts that have friction or restitution where their materials have none, or the reverse, with a bit
  // each. So have, with a third bit, those that came to triangles of such a material in this step.
  using Kind = std::pair<Part, std::uint8_t>;
  jobs::CompactArray<Kind> other_kinds_, other_kinds_before_;  // in order
  bool off_changed_ = false;
  std::uint64_t cache_changes_ = ~std::uint64_t{0};  // of the cache, once it was updated
  jobs::CompactArray<solver::AddedSlip> slips_;      // by slot, where there are any
};

}  // namespace atl
