// A world's state as bytes, and back. What a state doesn't tell follows from it, and is made anew or, where it is the
// same, kept.

#include <algorithm>
#include <cstring>
#include <iterator>

#include "state/roster_state.h"
#include "state/world_state.h"
#include "world/left_out.h"
#include "world/world_impl.h"

namespace atl {
namespace {

bool same_bits(const collision::Aabb& a, const collision::Aabb& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

std::size_t World::Impl::save_state(std::vector<std::byte>& bytes) const {
  StateWriter writer(bytes);
  WorldState(writer, *this).visit();
  return writer.size();
}

void World::Impl::restore(const std::shared_ptr<const Roster>& saved, std::uint64_t origin,
                          std::span<const std::byte> state) {
  if (known_as_ != saved && !are_same(*saved, *roster())) {
    if (origin != serial_) check_bodies_match(*saved, *roster());
    adopt(with_geometry(saved, *roster()));
  }
  known_as_ = saved;
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
  cache = {};
  broadphase = {};
  colliders = {};
  joints = {};
  joint_graph_ = {};
  joint_systems_ = {};
  joints_stale_ = true;
  bodies = {};
  records = {};
  sleeping = {};
  quarantine = {};
  selection_ = {};
  active_ = {};
  may_start_or_stop_.clear();
  reaches_.clear();
  aabbs.clear();
  surface_contacts_.clear();
  islands_ = {};
  islands_stale_ = true;
  touching_ = {};

  resize_bodies(roster->bodies.size());
  records.generation = roster->generation;
  records.free = roster->free;
  records.count = roster->bodies.size() - roster->free.size();
  for (std::uint32_t body = 0; body < roster->bodies.size(); ++body) {
    if (roster->bodies[body]) give_constants(body, roster->bodies[body]);
  }

  colliders.resize(roster->collider_body.size());
  colliders.free = roster->free_colliders;
  std::vector<std::vector<std::uint32_t>> of_body(roster->bodies.size());
  for (std::uint32_t collider = 0; collider < colliders.size(); ++collider) {
    const std::uint32_t body = roster->collider_body[collider];
    const std::uint32_t child = roster->collider_child[collider];
    colliders.child[collider] = child;
    if (body == collision::ColliderTable::none) continue;
    const BodyConstants& constants = *records.constants[body];
    const CheckedCollider& part = constants.colliders[child];
    colliders.place(collider, body, child, part.shape, part.in_frame_of(constants.centre));
    of_body[body].resize(constants.colliders.size());
    of_body[body][child] = collider;
  }
  for (std::size_t body = 0; body < of_body.size(); ++body) {
    if (of_body[body].empty()) continue;
    colliders.first[body] = of_body[body].front();
    for (std::size_t i = 1; i < of_body[body].size(); ++i) colliders.next[of_body[body][i - 1]] = of_body[body][i];
    note_size(static_cast<std::uint32_t>(body));
  }
  roster_ = roster;
}

void World::Impl::read_state(std::span<const std::byte> state) {
  StateReader reader(state);
  gather_kept_apart(kept_apart_before_);
  WorldState(reader, *this).visit();
  reader.check(reader.left() == 0, "more than there should be");
  dt_ = last_dt_;

  islands_stale_ = true;
  one_each_ = false;
  contact_update_.forget();
  touching_ = {};
  // Results are those of a step, and there was none.
  events_.told.clear();
  unasked_events_ = {};
  joint_events_.clear();
  escalated_.clear();
  captured_ = false;
  contact_forces_.clear();
  contact_forces_valid_ = true;
}

void World::Impl::restore_materials() {
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    const Material& material = records.material[body];
    if (records.alive[body]) {
      set_surface(body, {Vector3::Zero(), material.rolling_friction, material.torsional_friction});
    }
  }
}

void World::Impl::restore_quarantined(std::uint32_t body, Quarantine reason, std::int64_t step,
                                      const collision::Filter& filter) {
  quarantine.add({{body, records.generation[body]}, reason, quarantine_reason(reason), step},
                 {mobility_of(records.type[body]), records.constants[body]->gyroscopic, filter});
  colliders.for_each_of(body, [this](std::uint32_t collider) {
    if (broadphase.contains(collider)) broadphase.remove(collider);
  });
}

// Poses, velocities, and who sleeps or is in quarantine are known: who may move, and all that goes by body.
void World::Impl::note_restored_bodies() {
  contents = {};
  sleeping.asleep = 0;
  sleeping.changed.clear();
  pushed_.clear();
  aabbs.list_swept();
  may_start_or_stop_.clear();
  for (std::uint32_t body = 0; body < bodies.size(); ++body) {
    may_start_or_stop_.push_back(body);
    if (!bodies.force(body).isZero(0) || !bodies.torque(body).isZero(0)) pushed_.push_back(body);
    if (!records.alive[body]) continue;
    const bool out = quarantine.contains(body);
    const BodyConstants& constants = *records.constants[body];
    bodies.mobility[body] = out ? solver::Mobility::Fixed : mobility_of(constants.type);
    bodies.gyroscopic[body] = !out && constants.gyroscopic;
    records.dynamic[body] = !out && constants.type == BodyType::Dynamic;
    sleeping.awake[body] = records.dynamic[body] && !sleeping.is_asleep(body);
    sleeping.asleep += sleeping.is_asleep(body);
    if (!out) contents.count(bodies, records, body, +1);
  }
  if (update_active_bodies()) cache.set_active(active_.started(), active_.stopped());
}

void World::Impl::gather_kept_apart(std::vector<collision::Pair>& pairs) const {
  pairs.clear();
  for (const auto& [body, others] : records.ignored) {
    for (const std::uint32_t other : others) {
      if (body < other) pairs.push_back({body, other});
    }
  }
  joints.for_each_kept_apart([&](std::uint32_t a, std::uint32_t b) { pairs.push_back({a, b}); });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

void World::Impl::restore_kept_apart(std::span<const collision::Pair> told) {
  records.ignored.clear();
  for (const collision::Pair& pair : told) {
    records.ignored[pair.first].push_back(pair.second);
    records.ignored[pair.second].push_back(pair.first);
  }
  gather_kept_apart(kept_apart_);
  if (kept_apart_ == kept_apart_before_) return;
  std::vector<collision::Pair> changed;
  std::set_difference(kept_apart_before_.begin(), kept_apart_before_.end(), kept_apart_.begin(), kept_apart_.end(),
                      std::back_inserter(changed));
  for (const collision::Pair& pair : changed) broadphase.unignore(pair.first, pair.second);
  changed.clear();
  std::set_difference(kept_apart_.begin(), kept_apart_.end(), kept_apart_before_.begin(), kept_apart_before_.end(),
                      std::back_inserter(changed));
  for (const collision::Pair& pair : changed) broadphase.ignore(pair.first, pair.second);
}

bool World::Impl::is_in_broadphase(std::uint32_t collider) const {
  const std::uint32_t body = colliders.body[collider];
  return body != collision::ColliderTable::none && !quarantine.contains(body);
}

void World::Impl::restore_box(std::uint32_t collider, const collision::Aabb& box, const collision::Filter& filter) {
  if (!broadphase.contains(collider)) {
    add_box(collider, box, filter);
    return;
  }
  if (broadphase.filter(collider) != filter) broadphase.set_filter(collider, filter);
  if (!same_bits(broadphase.fat_box(collider), box)) broadphase.restore_box(collider, box);
}

void World::Impl::restore_plane(std::uint32_t collider, const collision::Plane& plane,
                                const collision::Filter& filter) {
  if (!broadphase.contains(collider)) {
    broadphase.add_half_space(collider, plane, filter);
    return;
  }
  if (broadphase.filter(collider) != filter) broadphase.set_filter(collider, filter);
  broadphase.restore_half_space(collider, plane);
}

bool World::Impl::may_touch(collision::Pair pair) const {
  return pair.first < pair.second && pair.second < colliders.size() && is_in_broadphase(pair.first) &&
         is_in_broadphase(pair.second) && colliders.body[pair.first] != colliders.body[pair.second];
}

// Contacts that are there already keep their slots.
void World::Impl::restore_pairs(std::span<const collision::Pair> pairs) {
  std::vector<collision::Pair> missing;
  auto next = pairs.begin();
  bool stays = false;
  cache.remove_any_if([&](std::uint32_t slot) {
    const collision::Contact& contact = cache.contacts[slot];
    if (contact.part == 0) {
      while (next != pairs.end() && *next < contact.pair) missing.push_back(*next++);
      stays = next != pairs.end() && *next == contact.pair;
      if (stays) ++next;
    }
    return !stays;
  });
  missing.insert(missing.end(), next, pairs.end());
  cache.add(missing, [this](collision::Pair pair) { return contact_start(pair); });
  if (!bodies.surfaces.empty()) surface_contacts_.resize(cache.manifolds.size());
}

}  // namespace atl
