#include <jobs/assert.h>
#include <solver/select/substep_control.h>
#include <solver/tuning.h>

#include <algorithm>

namespace atl::solver {
namespace {

// Contacts of an island that is looked at in parts, by all workers.
constexpr std::size_t part = 1024;
constexpr std::size_t large = 4 * part;
constexpr std::size_t island_grain = 32;

std::uint16_t rung_above(int substeps) {
  const auto above = std::upper_bound(substep_rungs.begin(), substep_rungs.end(), substeps);
  return above == substep_rungs.end() ? substep_rungs.back() : *above;
}

std::uint16_t rung_below(int substeps) {
  const auto here = std::lower_bound(substep_rungs.begin(), substep_rungs.end(), substeps);
  return here == substep_rungs.begin() ? substep_rungs.front() : *(here - 1);
}

}  // namespace

void SubstepControl::History::join(const History& other) {
  substeps = std::max(substeps, other.substeps);
  max = std::max(max, other.max);
  asked = std::max(asked, other.asked);
  needed = std::max(needed, other.needed);
  looked_at = std::max(looked_at, other.looked_at);
  hold = std::min(hold, other.hold);
  unchanged = std::min(unchanged, other.unchanged);
  lowered &= other.lowered;
}

void SubstepControl::forget_all() {
  history_.clear();
  islands_.clear();
  misses_.clear();
  motion_.forget_all();
}

const SubstepControl::History& SubstepControl::history(std::uint32_t body) const {
  static constexpr History none = {};
  return body < history_.size() ? history_[body] : none;
}

void SubstepControl::restore_history(std::uint32_t body, std::size_t bodies, const History& history) {
  ATL_ASSERT(body < bodies, body, bodies);
  history_.resize(bodies);
  history_[body] = history;
}

std::span<const SubstepControl::Island> SubstepControl::choose(const ErrorInput& input, const ErrorTarget& target,
                                                               jobs::Arena& arena) {
  history_.resize(input.bodies.size());
  ATL_ASSERT(target.min_substeps >= 1 && target.min_substeps <= target.max_substeps, target.min_substeps,
             target.max_substeps);
  substeps_.assign(input.bodies.size(), 0);
  const Islands& islands = input.islands;
  islands_.resize(islands.count());
  misses_.clear();
  needs_.assign(islands.count(), {});
  const std::span<const std::uint32_t> members = islands.bodies(0, islands.count());
  for (const std::uint32_t body : members) substeps_[body] = history_[body].substeps;
  measure(input, target, arena);
  for (std::size_t island = 0; island < islands.count(); ++island) decide(input, target, island);
  if (target.motion < ErrorTarget::none) {
    motion_.begin(input.bodies, members);
    motion_.begin(input.bodies, islands.free_bodies());
  } else if (!motion_.is_empty()) {
    motion_.forget_all();
  }
  return islands_;
}

void SubstepControl::measure(const ErrorInput& input, const ErrorTarget& target, jobs::Arena& arena) {
  const Islands& islands = input.islands;
  const bool overlaps = target.penetration < ErrorTarget::none;
  const bool gaps = target.joint_gap < ErrorTarget::none;
  arena.parallel_for(islands.count(), island_grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t island = begin; island < end; ++island) {
      if (overlaps && islands.contact_count(island) < large) {
        ErrorCounts counts;
        add_overlaps(input, islands.contacts(island, island + 1), substeps_, target.penetration, counts);
        needs_[island].overlap = counts.need(target.penetration);
      }
      if (gaps && islands.joint_count(island) > 0) {
        ErrorCounts counts;
        add_gaps(input, islands.joints(island, island + 1), substeps_, target.joint_gap, counts);
        needs_[island].gap = counts.need(target.joint_gap);
      }
    }
  });
  for (std::size_t island = 0; overlaps && island < islands.count(); ++island) {
    if (islands.contact_count(island) >= large) {
      needs_[island].overlap = overlap_of_large(input, target, island, arena);
    }
  }
}

ErrorNeed SubstepControl::overlap_of_large(const ErrorInput& input, const ErrorTarget& target, std::size_t island,
                                           jobs::Arena& arena) {
  const std::span<const TouchingPair> contacts = input.islands.contacts(island, island + 1);
  ATL_ASSERT(contacts.size() >= large, island, contacts.size());
  counts_.assign(jobs::Arena::chunk_count(contacts.size(), part), {});
  arena.parallel_for(contacts.size(), part, [&](std::size_t begin, std::size_t end) {
    for (std::size_t at = begin; at < end; at += part) {
      const std::size_t count = std::min(part, end - at);
      add_overlaps(input, contacts.subspan(at, count), substeps_, target.penetration, counts_[at / part]);
    }
  });
  ErrorCounts all;
  for (const ErrorCounts& counts : counts_) all += counts;
  return all.need(target.penetration);
}

void SubstepControl::decide(const ErrorInput& input, const ErrorTarget& target, std::size_t island) {
  const std::span<const std::uint32_t> members = input.islands.bodies(island, island + 1);
  constexpr auto hold = static_cast<float>(tuning::target_hold);
  constexpr auto longest = static_cast<float>(tuning::max_target_hold);
  History now = {.hold = longest, .unchanged = longest, .lowered = true};
  for (const std::uint32_t body : members) {
    if (history_[body].substeps > 0) now.join(history_[body]);
  }
  const auto allowed = [&target](int substeps) {
    return static_cast<std::uint16_t>(std::clamp(substeps, target.min_substeps, target.max_substeps));
  };
  if (now.substeps == 0) {
    now = {.substeps = allowed(substeps_at_first(input, target, island)), .hold = hold};
    // Nets and chains come under load as they fall.
    if (input.islands.joint_count(island) == 0) now.looked_at = hold - static_cast<float>(tuning::first_target_hold);
  }
  now.substeps = allowed(now.substeps);

  const Needs& needs = needs_[island];
  ATL_ASSERT(now.substeps >= 1, island, now.substeps);
  ATL_ASSERT(needs.overlap.substeps >= 0 && needs.gap.substeps >= 0, island, needs.overlap.substeps,
             needs.gap.substeps);
  const int found = std::max(needs.overlap.substeps, needs.gap.substeps);
  // Each change disturbs a residual: fewer are tried seldom, and one rung after the other.
  const bool for_residual = target.residual < ErrorTarget::none;
  const int others = std::max<int>(now.asked, for_residual ? rung_below(now.substeps) : 1);
  // A need found in one step only is ignored: bodies have it as they meet, and substeps given after that come too late.
  const std::uint16_t needed = allowed(std::max(std::min<int>(found, now.needed), others));
  now.looked_at += static_cast<float>(input.dt);
  now.unchanged = std::min(longest, now.unchanged + static_cast<float>(input.dt));
  const bool raises = (needs.overlap.follows || needs.gap.follows || now.asked > now.substeps) && needed > now.substeps;
  now.max = std::max(now.max, needed);
  if (raises) {
    // The last decrease went too far if about as many substeps are needed again: the next try comes later. A need for
    // many more has another cause.
    const bool again = now.lowered && needed <= 2 * now.substeps;
    now = {.substeps = needed, .max = needed, .hold = again ? std::min(2 * now.hold, longest) : hold};
  } else if (now.looked_at > (for_residual ? longest : now.hold)) {
    if (now.max < now.substeps) {
      now.substeps = now.max;
      now.lowered = true;
      now.unchanged = 0;
    }
    now.max = needed;
    now.looked_at = 0;
  }
  now.asked = 0;
  now.needed = static_cast<std::uint16_t>(found);
  for (const std::uint32_t body : members) history_[body] = now;

  islands_[island] = {now.substeps, static_cast<std::uint16_t>(std::max(found, others)), now.unchanged < hold};
  const auto number = static_cast<std::uint32_t>(island);
  if (needs.overlap.missed) {
    misses_.push_back({number, Error::Penetration, overlap_of(input, input.islands.contacts(island, island + 1))});
  }
  if (needs.gap.missed) {
    misses_.push_back({number, Error::JointGap, gap_of(input, input.islands.joints(island, island + 1))});
  }
}

void SubstepControl::note(const ErrorInput& input, const ErrorTarget& target, std::span<const double> residuals) {
  record_residuals(input, target, residuals);
  if (target.motion < ErrorTarget::none) record_motion(input, target);
  std::stable_sort(misses_.begin(), misses_.end(), [](const Miss& a, const Miss& b) { return a.island < b.island; });
}

void SubstepControl::record_residuals(const ErrorInput& input, const ErrorTarget& target,
                                      std::span<const double> residuals) {
  const Islands& islands = input.islands;
  ATL_ASSERT(residuals.empty() || residuals.size() == islands.count(), residuals.size(), islands.count());
  for (std::size_t island = 0; island < islands.count() && !residuals.empty(); ++island) {
    if (!(residuals[island] > target.residual)) continue;
    misses_.push_back({static_cast<std::uint32_t>(island), Error::Residual, residuals[island]});
    // Other substeps disturb it for a while, and nothing tells how many it takes: one rung after the other.
    const std::span<const std::uint32_t> members = islands.bodies(island, island + 1);
    if (history_[members.front()].unchanged < tuning::target_hold) continue;
    for (const std::uint32_t body : members) history_[body].asked = rung_above(islands_[island].substeps);
  }
}

void SubstepControl::record_motion(const ErrorInput& input, const ErrorTarget& target) {
  const Islands& islands = input.islands;
  const double step = input.dt * input.parts;
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const int substeps = islands_[island].substeps;
    ATL_ASSERT(substeps >= 1, island, substeps);
    ErrorCounts counts;
    double largest = 0;
    for (const std::uint32_t body : islands.bodies(island, island + 1)) {
      const double error = motion_.end(input.bodies, body, input.dt, step / substeps);
      if (error > target.motion) {
        counts.add_missed(error, error, substeps, target.motion);
      } else {
        counts.add(error, substeps, target.motion);
      }
      largest = std::max(largest, error);
    }
    const ErrorNeed need = counts.need(target.motion);
    if (need.missed) misses_.push_back({static_cast<std::uint32_t>(island), Error::Motion, largest});
    const auto asked = static_cast<std::uint16_t>(std::min<int>(need.substeps, substep_rungs.back()));
    for (const std::uint32_t body : islands.bodies(island, island + 1)) {
      history_[body].asked = std::max(history_[body].asked, asked);
    }
  }
  for (const std::uint32_t body : islands.free_bodies()) {
    motion_.end(input.bodies, body, input.dt, input.dt / input.asked);
  }
}

}  // namespace atl::solver
