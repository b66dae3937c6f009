// What the state of a world hashes to: who is there, and all that world_state.h has.

#include "state/roster_state.h"
#include "state/world_state.h"
#include "world/world_impl.h"

namespace atl {

std::uint64_t World::Impl::state_hash() const {
  StateHash hash;
  visit_numbers(hash, *roster());
  WorldState(hash, *this).visit();
  return hash.result();
}

const std::shared_ptr<const Roster>& World::Impl::roster() const {
  if (!roster_) {
    roster_ = std::make_shared<const Roster>(Roster{.bodies = records.constants,
                                                    .generation = records.generation,
                                                    .free = records.free,
                                                    .collider_body = colliders.body,
                                                    .collider_child = colliders.child,
                                                    .free_colliders = colliders.free});
  }
  return roster_;
}

// Bodies came or went.
void World::Impl::forget_roster() {
  roster_.reset();
  known_as_.reset();
}

}  // namespace atl
