#include <jobs/arrays.h>
#include <jobs/prefetch.h>

#include <algorithm>
#include <tuple>

#include "step/results.h"

namespace atl {
namespace {

// Calls visit(name, arrays, count, unit) for what a world's memory is for, in a fixed order.
template <typename Visit>
void for_each_use(const Stores& world, const StepPipeline& pipeline, const Visit& visit) {
  const SolvePhase& solve = pipeline.solve();
  const StepResults& results = world.results;
  const std::size_t bodies = world.records.count;
  const std::size_t shapes = world.colliders.body.size();
  const std::size_t touching = pipeline.contacts().touching().size();
  visit("bodies",
        std::tie(world.bodies, world.records, world.aabbs, world.active, world.changes.may_start_or_stop,
                 world.changes.pushed, world.reaches),
        bodies, "bodies");
  visit("sleeping", std::tie(world.sleeping), bodies, "bodies");
  visit("running_surfaces", std::tie(world.bodies.surfaces, world.surface_contacts), bodies, "bodies");
  visit("shapes", std::tie(world.colliders), shapes, "shapes");
  visit("broadphase", std::tie(world.broadphase), shapes, "shapes");
  visit("contacts", std::tie(world.cache, world.choices, pipeline.contacts()), world.cache.pairs.size(), "pairs");
  visit("islands", std::tie(pipeline.islands()), touching, "contacts");
  visit("contact_solver", solve.group_arrays(), touching, "contacts");
  visit("direct_contacts", solve.direct_arrays(), solve.direct_count(), "islands");
  visit("overload_watch", std::tuple_cat(std::tie(world.selection, results.solver_choices), solve.selection_arrays()),
        bodies, "bodies");
  visit("error_target", std::tie(world.control, results.missed_targets), bodies, "bodies");
  visit("joints", std::tuple_cat(std::tie(world.joints, results.joint_events), pipeline.islands().joint_arrays()),
        world.joints.count, "joints");
  visit("contact_events",
        std::tuple_cat(std::tie(results.contact_events, results.unasked_events), pipeline.event_arrays(),
                       solve.event_arrays()),
        results.contact_events.events.size(), "events");
  visit("sleep_events", std::tie(results.sleep_events), results.sleep_events.size(), "events");
  visit("sensors", std::tie(results.sensor_events), results.sensor_events.within.size(), "bodies");
  visit("accelerations", std::tie(results.accelerations), results.accelerations.linear.size() / 3, "bodies");
  visit("contact_problem", solve.capture_arrays(), solve.capture().answers.size(), "contacts");
}

}  // namespace

std::vector<MemoryUse> memory_of(const Stores& world, const StepPipeline& pipeline) {
  std::vector<MemoryUse> uses;
  for_each_use(world, pipeline, [&uses](const char* name, const auto& arrays, std::size_t count, const char* unit) {
    uses.push_back({name, jobs::bytes_of(arrays), count, unit});
  });
  return uses;
}

void prefetch(const Stores& world, const StepPipeline& pipeline) {
  // A quarter of the second-level cache of a small core: what goes beyond would push out what is in use.
  constexpr std::size_t limit = 128 << 10;
  std::size_t left = limit / jobs::cache_line;
  for_each_use(world, pipeline, [&left](const char*, const auto& arrays, std::size_t, const char*) {
    jobs::for_each_array(arrays, [&left](const auto& array) {
      const std::size_t lines = std::min(left, jobs::lines_of(array.size() * sizeof(array[0])));
      jobs::prefetch_lines(array.data(), lines);
      left -= lines;
    });
  });
}

}  // namespace atl
