#pragma once
/// Derived data of a state that is read (world_state.h): made anew, or kept if the state is the same.

#include <atoll/joint.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "world/stores.h"

namespace atl {

/// Surfaces as the materials have them.
void restore_materials(Stores& world);
void restore_quarantined(Stores& world, std::uint32_t body, Quarantine reason, std::int64_t step);
void restore_disabled(Stores& world, std::uint32_t body);
/// Poses, velocities, and who sleeps or is in quarantine are known: who may move, and all that goes by body.
void update_restored_bodies(Stores& world);

/// The definition as a state stores it. `bytes` holds the result.
std::span<const std::byte> definition_bytes(const JointDef& def, std::vector<std::byte>& bytes);
void restore_joint(Stores& world, std::uint32_t joint, const JointDef& def);
/// Has definitions of joints that are alike in memory that both worlds use.
void share_joint_definitions(Stores& to, const Stores& from);
/// All joints are there as they were saved; `same` if the world had them before.
void restore_joints(Stores& world, bool same);

/// Bodies that don't touch, by their users or by joints, in order.
std::vector<collision::Pair> pairs_kept_apart(const Stores& world);
void restore_disabled_pairs(Stores& world, std::span<const collision::Pair> pairs,
                            std::span<const collision::Pair> apart_before);

bool is_in_broadphase(const Stores& world, std::uint32_t collider);
void restore_box(Stores& world, std::uint32_t collider, const collision::Aabb& box);
void restore_plane(Stores& world, std::uint32_t collider, const collision::Plane& plane);
bool may_touch(const Stores& world, collision::Pair pair);
/// Contacts that are there already keep their slots.
void restore_pairs(Stores& world, std::span<const collision::Pair> pairs);

}  // namespace atl
