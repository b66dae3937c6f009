#include <jobs/bytes.h>

#include "step/results.h"

namespace atl {

using jobs::bytes_of;

std::vector<MemoryUse> memory_of(const Stores& world, const StepPipeline& pipeline, const StepCounts& last_step) {
  const SolvePhase& solve = pipeline.solve();
  const std::size_t contacts = world.cache.pairs.size();
  const std::size_t touching = pipeline.contacts().touching().size();
  std::vector<MemoryUse> uses;
  uses.push_back({"bodies",
                  world.bodies.bytes() + world.records.bytes() + world.aabbs.bytes() + world.active.bytes() +
                      bytes_of(world.changes.may_start_or_stop, world.changes.pushed, world.reaches),
                  world.records.count, "bodies"});
  uses.push_back({"sleeping", world.sleeping.bytes(), world.records.count, "bodies"});
  uses.push_back(
      {"running_surfaces", bytes_of(world.bodies.surfaces, world.surface_contacts), world.records.count, "bodies"});
  const std::size_t aabb_updates = world.aabbs.update_bytes();
  uses.push_back({"shapes", world.colliders.bytes(), world.colliders.body.size(), "shapes"});
  uses.push_back({"broadphase", world.broadphase.bytes() + aabb_updates, world.colliders.body.size(), "shapes"});
  const std::size_t of_contacts = world.cache.bytes() + world.choices.bytes() + pipeline.contacts().bytes();
  uses.push_back({"contacts", of_contacts, contacts, "pairs"});
  uses.push_back({"islands", pipeline.islands().bytes(), touching, "contacts"});
  uses.push_back({"contact_solver", solve.group_bytes(), touching, "contacts"});
  uses.push_back({"direct_contacts", solve.direct_bytes(), solve.direct_count(), "islands"});
  uses.push_back({"overload_watch",
                  world.selection.bytes() + solve.selection_bytes() + bytes_of(world.results.selected_solves),
                  world.records.count, "bodies"});
  const std::size_t of_joints =
      world.joints.bytes() + bytes_of(world.results.joint_events) + pipeline.islands().joint_bytes();
  uses.push_back({"joints", of_joints, world.joints.count, "joints"});
  uses.push_back(
      {"continuous_collision", pipeline.continuous().bytes(), static_cast<std::size_t>(last_step.swept), "bodies"});
  uses.push_back({"contact_events", world.results.contact_events.bytes() + world.results.unasked_events.bytes(),
                  world.results.contact_events.events.size(), "events"});
  uses.push_back({"contact_problem", solve.capture_bytes(), solve.capture().answers.size(), "contacts"});
  return uses;
}

}  // namespace atl
