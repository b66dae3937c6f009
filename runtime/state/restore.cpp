#include "state/restore.h"

#include <jobs/assert.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "state/joint_state.h"
#include "state/state_archive.h"
#include "world/bodies.h"
#include "world/colliders.h"
#include "world/joints.h"
#include "world/make_joint.h"

namespace atl {
namespace {

bool same_bits(const collision::Aabb& a, const collision::Aabb& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void restore_filter(Stores& world, std::uint32_t collider) {
  const collision::Filter filter = filter_of(world, collider);
  if (world.broadphase.filters().filter(collider) != filter) world.broadphase.set_filter(collider, filter);
}

}  // namespace

void restore_materials(Stores& world) {
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) {
    if (world.records.alive[body]) run_surface(world, body, {});
  }
}

namespace {

void leave_broadphase(Stores& world, std::uint32_t body) {
  world.colliders.for_each_of(body, [&](std::uint32_t collider) {
    if (world.broadphase.proxies().contains(collider)) world.broadphase.remove(collider);
  });
}

}  // namespace

void restore_quarantined(Stores& world, std::uint32_t body, Quarantine reason, std::int64_t step) {
  world.quarantine.add({{body, world.records.generation[body]}, reason, quarantine_reason(reason), step});
  leave_broadphase(world, body);
}

void restore_disabled(Stores& world, std::uint32_t body) {
  world.quarantine.disable(body);
  leave_broadphase(world, body);
}

void update_restored_bodies(Stores& world) {
  world.contents = {};
  world.sleeping.asleep = 0;
  world.sleeping.changed.clear();
  world.changes.pushed.clear();
  world.aabbs.list_swept();
  world.changes.may_start_or_stop.clear();
  for (std::uint32_t body = 0; body < world.bodies.size(); ++body) {
    world.changes.may_start_or_stop.push_back(body);
    if (!world.bodies.force(body).isZero(0) || !world.bodies.torque(body).isZero(0))
      world.changes.pushed.push_back(body);
    if (!world.records.alive[body]) continue;
    const bool out = world.quarantine.contains(body);
    const BodyConstants& constants = *world.records.constants[body];
    world.bodies.mobility[body] = out ? solver::Mobility::Fixed : mobility_of(constants.type);
    world.bodies.gyroscopic[body] = !out && constants.gyroscopic;
    world.records.dynamic[body] = !out && constants.type == BodyType::Dynamic;
    world.sleeping.awake[body] = world.records.dynamic[body] && !world.sleeping.is_asleep(body);
    world.sleeping.asleep += world.sleeping.is_asleep(body);
    if (!out) world.contents.count(world.bodies, world.records, body, +1);
  }
  update_active_bodies(world);
}

std::span<const std::byte> definition_bytes(const JointDef& def, std::vector<std::byte>& bytes) {
  StateWriter writer(bytes);
  visit_definition(writer, def);
  return {bytes.data(), writer.size()};
}

void restore_joint(Stores& world, std::uint32_t joint, const JointDef& def) {
  check_bodies(world, def);
  const JointDef normalised = checked(def);
  // Frames are stored as add_joint() left them: normalising them again might round otherwise.
  for (const auto& [frame, unit] :
       {std::pair{&def.frame_first, &normalised.frame_first}, std::pair{&def.frame_second, &normalised.frame_second}}) {
    if (!frame->orientation.coeffs().isApprox(unit->orientation.coeffs(), 1e-9)) {
      throw Error("Snapshot: found a joint with a frame that is not normalised; expected what World::save wrote");
    }
  }
  world.joints.def[joint] = std::make_shared<const JointDef>(def);
  world.joints.joints[joint] =
      make_joint(def, world.records.centre[def.first.index], world.records.centre[def.second.index]);
}

void share_joint_definitions(Stores& to, const Stores& from) {
  std::vector<std::byte> bytes, others_bytes;
  for (std::size_t joint = 0; joint < std::min(to.joints.size(), from.joints.size()); ++joint) {
    const std::shared_ptr<const JointDef>& other = from.joints.def[joint];
    if (std::ranges::equal(definition_bytes(*to.joints.def[joint], bytes), definition_bytes(*other, others_bytes))) {
      to.joints.def[joint] = other;
    }
  }
}

void restore_joints(Stores& world, bool same) {
  const auto acts_before = world.joints.acts;
  for (std::uint32_t joint = 0; joint < world.joints.size(); ++joint) {
    if (!world.joints.alive[joint]) {
      world.joints.clear(joint);
      continue;
    }
    solver::Joint& j = world.joints.joints[joint];
    if (j.is_tendon()) {
      bind_tendon(world, world.joints.def[joint]->kind, solver::Joint(j), j);
      continue;
    }
    world.joints.suspended[joint] =
        static_cast<std::uint8_t>(int{world.quarantine.contains(j.first)} + int{world.quarantine.contains(j.second)});
  }
  // A tendon acts as joints do that may come after it.
  for (std::uint32_t joint = 0; joint < world.joints.size(); ++joint) world.joints.update_flags(joint);
  if (!same) world.joints.rebuild();
  world.changes.joints |= !same || world.joints.acts != acts_before;
}

std::vector<collision::Pair> pairs_kept_apart(const Stores& world) {
  std::vector<collision::Pair> pairs;
  for (const auto& [body, others] : world.records.disabled_pairs) {
    for (const std::uint32_t other : others) {
      if (body < other) pairs.push_back({body, other});
    }
  }
  world.joints.for_each_kept_apart([&](std::uint32_t a, std::uint32_t b) { pairs.push_back({a, b}); });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

void restore_disabled_pairs(Stores& world, std::span<const collision::Pair> pairs,
                            std::span<const collision::Pair> apart_before) {
  ATL_ASSERT(std::is_sorted(apart_before.begin(), apart_before.end()), apart_before.size());
  world.records.disabled_pairs.clear();
  for (const collision::Pair& pair : pairs) world.records.disable_pair(pair.first, pair.second);
  const std::vector<collision::Pair> apart = pairs_kept_apart(world);
  std::vector<collision::Pair> changed;
  std::set_difference(apart_before.begin(), apart_before.end(), apart.begin(), apart.end(),
                      std::back_inserter(changed));
  for (const collision::Pair& pair : changed) world.broadphase.enable_pair(pair.first, pair.second);
  changed.clear();
  std::set_difference(apart.begin(), apart.end(), apart_before.begin(), apart_before.end(),
                      std::back_inserter(changed));
  for (const collision::Pair& pair : changed) world.broadphase.disable_pair(pair.first, pair.second);
}

bool is_in_broadphase(const Stores& world, std::uint32_t collider) {
  const std::uint32_t body = world.colliders.body[collider];
  return body != collision::ColliderTable::none && !world.quarantine.contains(body);
}

void restore_box(Stores& world, std::uint32_t collider, const collision::Aabb& box) {
  if (!world.broadphase.proxies().contains(collider)) {
    add_box(world, collider, box);
    return;
  }
  restore_filter(world, collider);
  if (!same_bits(world.broadphase.proxies().fat_box(collider), box)) world.broadphase.restore_box(collider, box);
}

void restore_plane(Stores& world, std::uint32_t collider, const collision::Plane& plane) {
  if (!world.broadphase.proxies().contains(collider)) {
    world.broadphase.add_half_space(collider, plane, filter_of(world, collider));
    return;
  }
  restore_filter(world, collider);
  world.broadphase.restore_half_space(collider, plane);
}

bool may_touch(const Stores& world, collision::Pair pair) {
  return pair.first < pair.second && pair.second < world.colliders.size() && is_in_broadphase(world, pair.first) &&
         is_in_broadphase(world, pair.second) && world.colliders.body[pair.first] != world.colliders.body[pair.second];
}

void restore_pairs(Stores& world, std::span<const collision::Pair> pairs) {
  std::vector<collision::Pair> missing;
  auto next = pairs.begin();
  bool stays = false;
  world.cache.remove_any_if([&](std::uint32_t slot) {
    const collision::Contact& contact = world.cache.contacts[slot];
    if (contact.part == 0) {
      while (next != pairs.end() && *next < contact.pair) missing.push_back(*next++);
      stays = next != pairs.end() && *next == contact.pair;
      if (stays) ++next;
    }
    return !stays;
  });
  missing.insert(missing.end(), next, pairs.end());
  world.cache.add(missing, [&](collision::Pair pair) { return contact_start(world, pair); });
  if (!world.bodies.surfaces.empty()) world.surface_contacts.resize(world.cache.manifolds.size());
}

}  // namespace atl
