// A world's state as bytes, and back; its hash.

#include "state/roster_state.h"
#include "state/world_state.h"
#include "world/bodies.h"
#include "world/colliders.h"
#include "world/left_out.h"
#include "world/world_impl.h"

namespace atl {

std::size_t World::Impl::save_state(std::vector<std::byte>& bytes) const {
  StateWriter writer(bytes);
  WorldState(writer, stores).visit();
  return writer.size();
}

void World::Impl::restore(const std::shared_ptr<const Roster>& saved, std::uint64_t origin,
                          std::span<const std::byte> state) {
  const bool is_known = roster_.known_as == saved && roster_.version == stores.records.version;
  if (!is_known && !are_same(*saved, *roster())) {
    if (origin != serial) check_bodies_match(*saved, *roster());
    adopt(with_geometry(saved, *roster()));
  }
  roster_.known_as = saved;
  read_state(state);
}

void World::Impl::try_out(const std::shared_ptr<const Roster>& roster, std::span<const std::byte> state) {
  Impl world({});
  world.adopt(roster);
  world.read_state(state);
}

// Other bodies: everything that knows bodies by their numbers starts afresh.
void World::Impl::adopt(const std::shared_ptr<const Roster>& roster) {
  for (const std::shared_ptr<const BodyConstants>& body : roster->bodies) {
    if (body) check_built_for(*body);
  }
  stores = {.gravity = stores.gravity, .settings = stores.settings};
  stores.changes.joints = true;
  pipeline.forget_bodies();

  resize_bodies(stores, roster->bodies.size());
  stores.records.generation = roster->generation;
  stores.records.free = roster->free;
  stores.records.count = roster->bodies.size() - roster->free.size();
  for (std::uint32_t body = 0; body < roster->bodies.size(); ++body) {
    if (roster->bodies[body]) give_constants(stores, body, roster->bodies[body]);
  }

  collision::ColliderTable& colliders = stores.colliders;
  colliders.resize(roster->collider_body.size());
  colliders.free = roster->free_colliders;
  std::vector<std::vector<std::uint32_t>> of_body(roster->bodies.size());
  for (std::uint32_t collider = 0; collider < colliders.size(); ++collider) {
    const std::uint32_t body = roster->collider_body[collider];
    const std::uint32_t child = roster->collider_child[collider];
    colliders.child[collider] = child;
    if (body == collision::ColliderTable::none) continue;
    const BodyConstants& constants = *stores.records.constants[body];
    const CheckedCollider& part = constants.colliders[child];
    colliders.place(collider, body, child, part.shape, part.in_frame_of(constants.centre));
    of_body[body].resize(constants.colliders.size());
    of_body[body][child] = collider;
  }
  for (std::size_t body = 0; body < of_body.size(); ++body) {
    if (of_body[body].empty()) continue;
    colliders.first[body] = of_body[body].front();
    for (std::size_t i = 1; i < of_body[body].size(); ++i) colliders.next[of_body[body][i - 1]] = of_body[body][i];
    note_size(stores, static_cast<std::uint32_t>(body));
  }
  roster_ = {.roster = roster, .known_as = nullptr, .version = stores.records.version};
  query_gate.note(stores.broadphase);
}

void World::Impl::read_state(std::span<const std::byte> state) {
  StateReader reader(state);
  WorldState(reader, stores).visit();
  reader.check(reader.left() == 0, "more than there should be");
  stores.clock.dt = stores.clock.last_dt;
  stores.changes.islands = true;
  pipeline.forget();
  query_gate.note(stores.broadphase);
  // Results are those of a step, and there was none.
  StepResults& results = stores.results;
  results.contact_events.told.clear();
  results.unasked_events = {};
  results.sensor_events.told.clear();
  results.joint_events.clear();
  results.escalated_islands.clear();
  results.captured = false;
  results.contact_forces.clear();
  results.contact_forces_valid = true;
}

std::uint64_t World::Impl::state_hash() const {
  StateHash hash;
  visit_numbers(hash, *roster());
  WorldState(hash, stores).visit();
  return hash.result();
}

const std::shared_ptr<const Roster>& World::Impl::roster() const {
  const BodyRecords& records = stores.records;
  if (!roster_.roster || roster_.version != records.version) {
    roster_ = {.roster = std::make_shared<const Roster>(Roster{.bodies = records.constants,
                                                               .generation = records.generation,
                                                               .free = records.free,
                                                               .collider_body = stores.colliders.body,
                                                               .collider_child = stores.colliders.child,
                                                               .free_colliders = stores.colliders.free}),
               .known_as = nullptr,
               .version = records.version};
  }
  return roster_.roster;
}

}  // namespace atl
