#include "world/active_bodies.h"

#include <jobs/assert.h>

#include <algorithm>

namespace atl {

void ActiveBodies::apply_changes() {
  std::sort(started_.begin(), started_.end());
  std::sort(stopped_.begin(), stopped_.end());
  if (!stopped_.empty()) jobs::erase_if(bodies_, [this](std::uint32_t body) { return !contains(body); });
  // Both parts are in order. From the back, so that nothing is overwritten before it has moved.
  std::size_t old_left = bodies_.size();
  std::size_t started_left = started_.size();
  bodies_.resize(old_left + started_left);
  while (started_left > 0) {
    const std::uint32_t started = started_[started_left - 1];
    const bool old_is_later = old_left > 0 && started < bodies_[old_left - 1];
    ATL_ASSERT(old_left == 0 || started != bodies_[old_left - 1], started, old_left);
    ATL_ASSERT(started < active_.size() && contains(started), started, active_.size());
    bodies_[old_left + started_left - 1] = old_is_later ? bodies_[old_left - 1] : started;
    --(old_is_later ? old_left : started_left);
  }
}

}  // namespace atl
