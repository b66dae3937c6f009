#include "step/sensors.h"

#include <collision/queries/query.h>
#include <jobs/assert.h>

#include <algorithm>
#include <compare>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "world/bodies.h"
#include "world/colliders.h"

namespace atl {
namespace {

// Two shapes that met, of a sensor and a body.
struct Meeting {
  std::uint32_t body;
  std::uint32_t child_sensor, child_body;

  auto operator<=>(const Meeting&) const = default;
};

// Each body once, in order, by its lowest children.
void leave_one_each(std::vector<Meeting>& meetings) {
  std::sort(meetings.begin(), meetings.end());
  const auto same = [](const Meeting& x, const Meeting& y) { return x.body == y.body; };
  meetings.erase(std::unique(meetings.begin(), meetings.end(), same), meetings.end());
}

// A sensor and what it looks at.
class Sensor {
 public:
  Sensor(const Stores& world, std::uint32_t body)
      : world_(world),
        body_(body),
        constants_(*world.records.constants[body]),
        scene_{world.colliders, {world.bodies.positions.data(), world.bodies.orientations.data()}, world.broadphase} {}

  // Appends who is in the sensor.
  void find_within(std::vector<Meeting>& found) const;
  // Appends whom it meets on their ways in the step.
  void find_passing(std::vector<Meeting>& found) const;

 private:
  bool notices(const collision::Filter& own, std::uint32_t collider) const;
  collision::Motion motion_of(std::uint32_t collider) const;
  bool comes_near(std::uint32_t body) const;
  void sweep(std::uint32_t part, std::uint32_t collider, std::vector<Meeting>& found) const;
  Vector3 travel(std::uint32_t body) const {
    return world_.bodies.position(body) - Eigen::Map<const Vector3>(&started().start_positions[3 * std::size_t{body}]);
  }
  // m, of the points of a body by its turning in the step, at most.
  double turning_path(const collision::Motion& motion, std::uint32_t collider) const {
    return motion.rotation.norm() * world_.bodies.radius[world_.colliders.body[collider]];
  }
  const SensorEvents& started() const { return world_.results.sensor_events; }
  void add(std::uint32_t part, std::uint32_t collider, std::vector<Meeting>& found) const {
    found.push_back({world_.colliders.body[collider], world_.colliders.child[part], world_.colliders.child[collider]});
  }

  const Stores& world_;
  std::uint32_t body_;
  const BodyConstants& constants_;
  collision::QueryScene scene_;
};

bool Sensor::notices(const collision::Filter& own, std::uint32_t collider) const {
  const BodyRecords& records = world_.records;
  const std::uint32_t body = world_.colliders.body[collider];
  if (records.type[body] == BodyType::Static && !constants_.notices_static) return false;
  if (records.sensor[body] && !constants_.notices_sensors) return false;
  const bool meets = records.sensor[body] ? collision::may_meet(own, own_filter_of(world_, collider))
                                          : collision::may_meet(own, world_.broadphase.filters().filter(collider));
  return meets && world_.bodies.position(body).allFinite();
}

void Sensor::find_within(std::vector<Meeting>& found) const {
  if (!world_.bodies.position(body_).allFinite()) return;
  std::vector<std::uint32_t> touched;
  world_.colliders.for_each_of(body_, [&](std::uint32_t part) {
    const collision::Filter own = own_filter_of(world_, part);
    const auto accept = [&](std::uint32_t collider) { return notices(own, collider); };
    collision::find_overlaps(scene_, world_.colliders.shape[part], world_.colliders.pose(part, scene_.poses), accept,
                             touched);
    for (const std::uint32_t collider : touched) add(part, collider, found);
  });
  leave_one_each(found);
}

// In the step, turning the shorter way.
collision::Motion Sensor::motion_of(std::uint32_t collider) const {
  const std::uint32_t body = world_.colliders.body[collider];
  const collision::PoseView starts{started().start_positions.data(), started().start_orientations.data()};
  const collision::Pose start = world_.colliders.pose(collider, starts);
  const Vector3 centre = Eigen::Map<const Vector3>(&started().start_positions[3 * std::size_t{body}]);
  return collision::Motion::between(start, world_.colliders.pose(collider, scene_.poses),
                                    start.orientation.conjugate() * (centre - start.position));
}

// True if the bounding spheres of a body and the sensor meet on their ways through the step.
bool Sensor::comes_near(std::uint32_t body) const {
  const double reach = world_.bodies.radius[body] + world_.bodies.radius[body_];
  if (world_.bodies.radius[body] == 0) return true;
  const Vector3 end = world_.bodies.position(body) - world_.bodies.position(body_);
  const Vector3 way = travel(body) - travel(body_);
  const double square = way.squaredNorm();
  const double back = square > 0 ? std::clamp(end.dot(way) / square, 0.0, 1.0) : 0;
  return (end - back * way).squaredNorm() <= reach * reach;
}

void Sensor::sweep(std::uint32_t part, std::uint32_t collider, std::vector<Meeting>& found) const {
  if (!notices(own_filter_of(world_, part), collider)) return;
  const collision::Shape& solid = world_.colliders.shape[part];
  const collision::Shape& other = world_.colliders.shape[collider];
  const double size = other.inner_radius > 0 ? std::min(solid.inner_radius, other.inner_radius) : solid.inner_radius;
  const double tolerance = 1e-6 * size;
  const collision::Motion own = motion_of(part), its = motion_of(collider);
  collision::SweepHit hit;
  if (!collision::sweep(solid, own, other, its, {.tolerance = tolerance}, 1, hit)) return;
  // Sweeps hit early, by up to the tolerance. A body that can't get in deeper by the end has not passed yet: it is
  // within at the end, or the next step tells.
  const Vector3 way = own.translation - its.translation;
  const bool one_normal = hit.triangle == collision::SweepHit::no_triangle;
  const double closing =
      (one_normal ? way.dot(hit.normal) : way.norm()) + turning_path(own, part) + turning_path(its, collider);
  if ((1 - hit.t) * closing > tolerance) add(part, collider, found);
}

void Sensor::find_passing(std::vector<Meeting>& found) const {
  ATL_ASSERT(started().start_positions.size() == world_.bodies.positions.size(), body_,
             started().start_positions.size(), world_.bodies.positions.size());
  const auto is_sound = [&](std::uint32_t body) { return travel(body).allFinite(); };
  if (!is_sound(body_)) return;
  for (const std::uint32_t body : world_.active.in_order()) {
    if (body == body_ || !is_sound(body) || !comes_near(body)) continue;
    world_.colliders.for_each_of(body_, [&](std::uint32_t part) {
      world_.colliders.for_each_of(body, [&](std::uint32_t collider) { sweep(part, collider, found); });
    });
  }
  if (!travel(body_).isZero(0)) {
    const Vector3 reach = Vector3::Constant(world_.bodies.radius[body_]);
    const Vector3 end = world_.bodies.position(body_), start = end - travel(body_);
    const auto swept = collision::Aabb::around(start.cwiseMin(end) - reach, start.cwiseMax(end) + reach);
    world_.broadphase.proxies().query_box(swept, [&](std::uint32_t collider) {
      const std::uint32_t body = world_.colliders.body[collider];
      if (body == body_ || world_.active.contains(body)) return;
      world_.colliders.for_each_of(body_, [&](std::uint32_t part) { sweep(part, collider, found); });
    });
  }
  leave_one_each(found);
}

// `meetings`: of those within, one each.
void tell_changes(std::span<const Meeting> meetings, SensorEvents& events) {
  ATL_ASSERT(meetings.size() == events.within.size(), meetings.size(), events.within.size());
  ATL_ASSERT(std::is_sorted(events.before.begin(), events.before.end()), events.before.size());
  ATL_ASSERT(std::is_sorted(events.within.begin(), events.within.end()), events.within.size());
  auto before = events.before.begin();
  auto now = events.within.begin();
  while (before != events.before.end() || now != events.within.end()) {
    const bool left = now == events.within.end() || (before != events.before.end() && *before < *now);
    const bool entered = before == events.before.end() || (now != events.within.end() && *now < *before);
    if (left) events.events.push_back({before->first, before->second, false});
    if (entered) {
      const Meeting& meeting = meetings[static_cast<std::size_t>(now - events.within.begin())];
      events.events.push_back({now->first, now->second, true, meeting.child_sensor, meeting.child_body});
    }
    if (!entered) ++before;
    if (!left) ++now;
  }
}

// Whom a sensor met on their ways, and who is in it neither before nor after.
void tell_passing(const Stores& world, std::uint32_t sensor, std::span<const Meeting> passing, SensorEvents& events) {
  const BodyId id = id_of(world, sensor);
  const auto holds = [&](const std::vector<std::pair<BodyId, BodyId>>& pairs, BodyId body) {
    return std::binary_search(pairs.begin(), pairs.end(), std::pair(id, body));
  };
  for (const Meeting& meeting : passing) {
    const BodyId body = id_of(world, meeting.body);
    if (holds(events.before, body) || holds(events.within, body)) continue;
    events.events.push_back({id, body, true, meeting.child_sensor, meeting.child_body});
    events.events.push_back({id, body, false});
  }
}

}  // namespace

void begin_sensing(Stores& world) {
  SensorEvents& events = world.results.sensor_events;
  if (world.contents.continuous_sensors == 0) return;
  events.start_positions.assign(world.bodies.positions.begin(), world.bodies.positions.end());
  events.start_orientations.assign(world.bodies.orientations.begin(), world.bodies.orientations.end());
}

void record_sensor_events(Stores& world, jobs::Arena& arena) {
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
  std::vector<std::vector<Meeting>> found(sensors.size()), passing(sensors.size());
  arena.parallel_for(sensors.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Sensor sensor(world, sensors[i]);
      sensor.find_within(found[i]);
      if (world.records.continuous[sensors[i]]) sensor.find_passing(passing[i]);
    }
  });
  std::swap(events.before, events.within);
  events.within.clear();
  std::vector<Meeting> meetings;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (const Meeting& one : found[i]) events.within.emplace_back(id_of(world, sensors[i]), id_of(world, one.body));
    meetings.insert(meetings.end(), found[i].begin(), found[i].end());
  }
  tell_changes(meetings, events);
  if (world.contents.continuous_sensors == 0) return;
  for (std::size_t i = 0; i < sensors.size(); ++i) tell_passing(world, sensors[i], passing[i], events);
  std::stable_sort(events.events.begin(), events.events.end(), [](const SensorEvent& x, const SensorEvent& y) {
    return std::tie(x.sensor, x.body) < std::tie(y.sensor, y.body);
  });
}

}  // namespace atl
