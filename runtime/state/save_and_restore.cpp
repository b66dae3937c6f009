// A world's state as bytes, and back; its hash.

#include <utility>

#include "state/world_definition_state.h"
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

void World::Impl::restore(const std::shared_ptr<const WorldDefinition>& saved, std::uint64_t origin,
                          std::span<const std::byte> state, bool from_file) {
  const bool half_done = step_guard.is_half_done();
  const bool is_known = world_definition_.known_as == saved && world_definition_.version == stores.records.version;
  if (half_done || (!is_known && !are_same(*saved, *world_definition()))) {
    if (origin != serial && !half_done) check_bodies_match(*saved, *world_definition());
    adopt(with_geometry(saved, *world_definition()));
  }
  world_definition_.known_as = saved;
  read_state(state, from_file);
  step_guard.begin_anew();
}

void World::Impl::try_out(const std::shared_ptr<const WorldDefinition>& world_definition,
                          std::span<const std::byte> state) {
  Impl world({});
  world.adopt(world_definition);
  world.read_state(state, true);
}

// Other bodies: everything that knows bodies by their numbers starts afresh.
void World::Impl::adopt(const std::shared_ptr<const WorldDefinition>& world_definition) {
  for (const std::shared_ptr<const BodyConstants>& body : world_definition->bodies) {
    if (body) check_built_for(*body);
  }
  viewed.leave(stores.bodies);
  // By its constructor: GCC 12 destroys members twice if memory runs out in a braced list.
  Stores fresh;
  fresh.gravity = stores.gravity;
  fresh.settings = stores.settings;
  stores = std::move(fresh);
  stores.changes.joints = true;
  pipeline = {};

  resize_bodies(stores, world_definition->bodies.size());
  stores.records.generation = world_definition->generation;
  stores.records.free = world_definition->free;
  stores.records.count = world_definition->bodies.size() - world_definition->free.size();
  for (std::uint32_t body = 0; body < world_definition->bodies.size(); ++body) {
    if (world_definition->bodies[body]) give_constants(stores, body, world_definition->bodies[body]);
  }

  collision::ColliderTable& colliders = stores.colliders;
  colliders.resize(world_definition->collider_body.size());
  colliders.free = world_definition->free_colliders;
  std::vector<std::vector<std::uint32_t>> of_body(world_definition->bodies.size());
  for (std::uint32_t collider = 0; collider < colliders.size(); ++collider) {
    const std::uint32_t body = world_definition->collider_body[collider];
    const std::uint32_t child = world_definition->collider_child[collider];
    colliders.child[collider] = child;
    if (body == collision::ColliderTable::none) continue;
    const BodyConstants& constants = *stores.records.constants[body];
    const CheckedCollider& part = constants.colliders[child];
    const collision::PlacedShape placed = part.in_frame_of(constants.centre);
    colliders.place(collider, body, child, placed.shape, placed.pose);
    of_body[body].resize(constants.colliders.size());
    of_body[body][child] = collider;
  }
  for (std::size_t body = 0; body < of_body.size(); ++body) {
    if (of_body[body].empty()) continue;
    colliders.first[body] = of_body[body].front();
    for (std::size_t i = 1; i < of_body[body].size(); ++i) colliders.next[of_body[body][i - 1]] = of_body[body][i];
    update_size(stores, static_cast<std::uint32_t>(body));
  }
  world_definition_ = {.world_definition = world_definition, .known_as = nullptr, .version = stores.records.version};
  query_gate.note(stores.broadphase);
}

void World::Impl::read_state(std::span<const std::byte> state, bool from_file) {
  StateReader reader(state, {.from_file = from_file});
  WorldState(reader, stores).visit();
  reader.check(reader.left() == 0, "more than there should be");
  stores.clock.dt = stores.clock.last_dt;
  stores.changes.islands = true;
  pipeline.forget();
  query_gate.note(stores.broadphase);
  // Results are those of a step, and there was none.
  StepResults& results = stores.results;
  results.contact_events.events.clear();
  results.unasked_events = {};
  results.sensor_events.events.clear();
  results.joint_events.clear();
  results.sleep_events.clear();
  results.solver_choices.clear();
  results.missed_targets.clear();
  results.captured = false;
  results.accelerations = {};
  results.contact_forces.clear();
  results.contact_forces_valid = true;
}

std::uint64_t World::Impl::state_hash() const {
  StateHash hash;
  visit_numbers(hash, *world_definition());
  WorldState(hash, stores).visit();
  return hash.result();
}

const std::shared_ptr<const WorldDefinition>& World::Impl::world_definition() const {
  const BodyRecords& records = stores.records;
  if (!world_definition_.world_definition || world_definition_.version != records.version) {
    world_definition_ = {.world_definition = std::make_shared<const WorldDefinition>(
                             WorldDefinition{.bodies = records.constants,
                                             .generation = records.generation,
                                             .free = records.free,
                                             .collider_body = stores.colliders.body,
                                             .collider_child = stores.colliders.child,
                                             .free_colliders = stores.colliders.free}),
                         .known_as = nullptr,
                         .version = records.version};
  }
  return world_definition_.world_definition;
}

}  // namespace atl
