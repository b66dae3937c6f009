#pragma once

#include <atoll/types.h>
#include <collision/broadphase/pair.h>
#include <jobs/arrays.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl {

/// Answers of a contact filter that stay valid, and the questions still open. The functions themselves are no part of a
/// world's state: see step/contact_rules.h.
struct ContactChoices {
  /// Colliders that may not touch, in order. A pair stays here until their fat AABBs come apart.
  std::vector<collision::Pair> refused;
  std::vector<std::uint32_t> refiltered;  ///< bodies of which the next step asks again, in order

  /// A contact that the last step's modifier changed: its slot gets back what materials say.
  struct Modified {
    std::uint32_t slot;
    collision::Pair pair;
  };
  std::vector<Modified> modified;

  bool is_refused(collision::Pair pair) const { return std::binary_search(refused.begin(), refused.end(), pair); }
  bool is_empty() const { return refused.empty() && refiltered.empty(); }
  auto arrays() const { return std::tie(refused, refiltered, modified); }
};

/// Puts pairs to others; both are in order.
inline void add_in_order(std::vector<collision::Pair>& to, std::span<const collision::Pair> more) {
  const auto size = static_cast<std::ptrdiff_t>(to.size());
  to.insert(to.end(), more.begin(), more.end());
  std::inplace_merge(to.begin(), to.begin() + size, to.end());
}

}  // namespace atl
