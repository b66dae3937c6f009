#include "world/put_to_sleep.h"

#include <features/with_joints.h>
#include <solver/constraints/tendon.h>

#include <algorithm>
#include <vector>

namespace atl {
namespace {

// Dynamic bodies that touch each other or are joined, from one of them on, in order.
std::vector<std::uint32_t> island_of(const Stores& world, std::uint32_t body) {
  std::vector<std::uint32_t> island = {body};
  std::vector<std::uint8_t> found(world.bodies.size(), 0);
  found[body] = 1;
  const auto add = [&](std::uint32_t other) {
    if (!world.sleeping.awake[other] || found[other] != 0) return;
    found[other] = 1;
    island.push_back(other);
  };
  const auto add_both = [&](const solver::Joint& joint) {
    add(joint.first);
    add(joint.second);
  };
  for (std::size_t next = 0; next < island.size(); ++next) {
    const std::uint32_t member = island[next];
    world.cache.for_each_contact_of(member, [&](std::uint32_t slot) {
      const collision::Contact& contact = world.cache.contacts[slot];
      if (contact.count == 0) return;
      add(contact.body_first);
      add(contact.body_second);
    });
    if constexpr (!with_joints) continue;
    world.joints.for_each_of(member, [&](std::uint32_t joint) {
      if (world.joints.acts[joint]) add_both(world.joints.joints[joint]);
      for (const std::uint32_t tendon : world.joints.tendons_over(joint)) {
        if (world.joints.acts[tendon]) solver::for_each_term(world.joints.joints.data(), tendon, add_both);
      }
    });
  }
  std::sort(island.begin(), island.end());
  return island;
}

}  // namespace

void put_to_sleep(Stores& world, std::uint32_t body) {
  if (!world.sleeping.awake[body]) return;
  const std::vector<std::uint32_t> island = island_of(world, body);
  if (std::ranges::any_of(island, [&](std::uint32_t member) { return world.sleeping.stays_awake(member); })) return;
  for (const std::uint32_t member : island) {
    world.bodies.clear_push(member);
    world.quarantine.suspect(member);
  }
  world.sleeping.put_to_sleep(island, world.bodies);
}

}  // namespace atl
