#include "population.h"

#include <atoll/queries.h>

#include <algorithm>

namespace atl::soak {
namespace {

constexpr std::size_t of_each_kind = 6;
constexpr int tries = 4;                       // of places, a thing and step
constexpr double clearance = 0.1;              // m around what comes
constexpr std::int64_t all_come_within = 300;  // steps

}  // namespace

Population::Population(Twin& twin, Random& random) : twin_(twin), random_(random) {
  for (std::size_t i = 0; i < of_each_kind * thing_kinds(); ++i) {
    residents_.push_back(
        {.kind = i % thing_kinds(), .until = static_cast<std::int64_t>(pick(random_, all_come_within))});
  }
}

void Population::come_and_go(std::int64_t step, SoakTally& tally) {
  tally.waiting = 0;
  for (Resident& resident : residents_) {
    if (resident.until > step) continue;
    if (!resident.bodies.empty()) go(resident, step, tally);
    if (!come(resident, step, tally)) ++tally.waiting;
  }
}

std::optional<Pose> Population::free_place(const Thing& thing) {
  const Queries queries(twin_.world());
  for (int i = 0; i < tries; ++i) {
    const double side = chance(random_, 2) ? 1 : 0.6;
    const Quaternion turn = Quaternion(side, 0, 0, random_.uniform(-1, 1)).normalized();
    const Pose pose = {place_above(pick(random_, place_count)), turn};
    const Box room = {thing.half + Vector3::Constant(clearance)};
    if (queries.overlapping({.shape = room, .position = pose.position, .orientation = turn}).empty()) return pose;
  }
  return std::nullopt;
}

bool Population::come(Resident& resident, std::int64_t step, SoakTally& tally) {
  const Thing thing = make_thing(resident.kind, random_);
  const std::optional<Pose> pose = free_place(thing);
  if (!pose) return false;
  resident.name = thing.kind;
  for (const BodyDef& body : thing.bodies) {
    const BodyDef def = placed(body, *pose);
    resident.bodies.push_back(twin_.each([&](World& world) { return world.add_body(def); }));
    resident.masses.push_back(twin_.world().mass(resident.bodies.back()));
  }
  for (const Link& link : thing.links) {
    const JointDef def = joint_of(link, thing, resident.bodies[link.first], resident.bodies[link.second]);
    resident.joints.push_back(twin_.each([&](World& world) { return world.add_joint(def); }));
  }
  resident.until = step + shortest_stay + static_cast<std::int64_t>(pick(random_, longest_stay - shortest_stay));
  ++tally.came;
  return true;
}

void Population::go(Resident& resident, std::int64_t step, SoakTally& tally) {
  for (const BodyId body : resident.bodies) twin_.each([&](World& world) { world.remove_body(body); });
  resident.bodies.clear();
  resident.masses.clear();
  resident.joints.clear();
  resident.until = step;
  ++tally.went;
}

void Population::remove_with(BodyId body, std::int64_t step, SoakTally& tally) {
  for (Resident& resident : residents_) {
    if (std::find(resident.bodies.begin(), resident.bodies.end(), body) == resident.bodies.end()) continue;
    return go(resident, step, tally);
  }
}

const char* Population::name_of(BodyId body) const {
  for (const Resident& resident : residents_) {
    if (std::find(resident.bodies.begin(), resident.bodies.end(), body) != resident.bodies.end()) return resident.name;
  }
  return "yard";
}

const Resident* Population::draw() {
  const Resident& drawn = residents_[pick(random_, residents_.size())];
  if (drawn.bodies.empty() || twin_.world().type(drawn.bodies.front()) != BodyType::Dynamic) return nullptr;
  return &drawn;
}

std::optional<BodyId> Population::draw_body() {
  const Resident* drawn = draw();
  if (drawn == nullptr) return std::nullopt;
  return drawn->bodies[pick(random_, drawn->bodies.size())];
}

}  // namespace atl::soak
