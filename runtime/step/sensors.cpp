#include "step/sensors.h"

#include <collision/queries/query.h>

#include <algorithm>

#include "world/bodies.h"
#include "world/colliders.h"

namespace atl {
namespace {

// Appends who is in the sensor to `found`, each once, in order.
void find_within(const Stores& world, std::uint32_t sensor, std::vector<std::uint32_t>& found) {
  const collision::QueryScene scene{
      world.colliders, {world.bodies.positions.data(), world.bodies.orientations.data()}, world.broadphase};
  if (!world.bodies.position(sensor).allFinite()) return;
  std::vector<std::uint32_t> touched;
  world.colliders.for_each_of(sensor, [&](std::uint32_t part) {
    const CheckedCollider& own = world.records.constants[sensor]->colliders[world.colliders.child[part]];
    const CollisionFilter& asked = own.filter ? *own.filter : world.records.filter[sensor];
    const collision::Filter filter{asked.category, asked.mask, asked.group, sensor};
    const auto notices = [&](std::uint32_t collider) {
      const std::uint32_t body = world.colliders.body[collider];
      return world.records.type[body] != BodyType::Static && !world.records.sensor[body] &&
             collision::may_meet(filter, world.broadphase.filters().filter(collider)) &&
             world.bodies.position(body).allFinite();
    };
    collision::find_overlaps(scene, world.colliders.shape[part], world.colliders.pose(part, scene.poses), notices,
                             touched);
    for (const std::uint32_t collider : touched) found.push_back(world.colliders.body[collider]);
  });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

void tell_changes(SensorEvents& events) {
  auto before = events.before.begin();
  auto now = events.within.begin();
  while (before != events.before.end() || now != events.within.end()) {
    const bool left = now == events.within.end() || (before != events.before.end() && *before < *now);
    const bool entered = before == events.before.end() || (now != events.within.end() && *now < *before);
    if (left || entered) {
      const auto& [sensor, body] = left ? *before : *now;
      events.events.push_back({sensor, body, entered});
    }
    if (!entered) ++before;
    if (!left) ++now;
  }
}

}  // namespace

void note_sensor_events(Stores& world, jobs::Arena& arena) {
  SensorEvents& events = world.results.sensor_events;
  events.events.clear();
  if (world.contents.sensors == 0 && events.within.empty()) return;
  std::vector<std::uint32_t> sensors;
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) {
    if (world.records.alive[body] && world.records.sensor[body] && !world.quarantine.contains(body)) {
      sensors.push_back(body);
    }
  }
  if (world.broadphase.is_behind()) world.broadphase.take_in(arena);
  std::vector<std::vector<std::uint32_t>> found(sensors.size());
  arena.parallel_for(sensors.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) find_within(world, sensors[i], found[i]);
  });
  std::swap(events.before, events.within);
  events.within.clear();
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (const std::uint32_t body : found[i]) events.within.emplace_back(id_of(world, sensors[i]), id_of(world, body));
  }
  tell_changes(events);
}

}  // namespace atl
