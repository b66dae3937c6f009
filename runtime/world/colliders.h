#pragma once
/// Bodies' shapes, and their AABBs in the broadphase.

#include <cstdint>

#include "world/stores.h"

namespace atl {

/// The motions that the AABBs of bodies follow.
collision::BodyMotions motions(const Stores& world);

void add_colliders(Stores& world, std::uint32_t body);
/// Removes the colliders of a body that is in the broadphase no longer.
void clear_colliders(Stores& world, std::uint32_t body);
/// The same of a body that goes, and with them who doesn't touch it.
void remove_colliders(Stores& world, std::uint32_t body);
/// How far the shapes of a new body reach, and what that makes of its motion. Only dynamic bodies are stopped by what
/// they hit; how kinematic ones move is part of what these meet.
void update_size(Stores& world, std::uint32_t body);

/// A collider's, or its body's where it has none of its own.
const Material& material_of(const Stores& world, std::uint32_t collider, std::uint8_t number = 0);
/// The filter of a collider, or its body's where it has none of its own.
collision::Filter own_filter_of(const Stores& world, std::uint32_t collider);
/// The same, as the broadphase wants it: nothing meets a sensor there.
collision::Filter filter_of(const Stores& world, std::uint32_t collider);

/// See World::bounds().
BoundingBox bounds_of(const Stores& world, std::uint32_t body);

/// Puts all colliders of a body into the broadphase.
void add_proxies(Stores& world, std::uint32_t body);
/// Puts one there whose fat AABB is known.
void add_box(Stores& world, std::uint32_t collider, const collision::Aabb& box);
/// A body was put elsewhere, or left its AABBs.
void move_proxies(Stores& world, std::uint32_t body);

/// The initial data of a contact between two colliders.
collision::ContactCache::Start contact_start(const Stores& world, collision::Pair pair, std::uint8_t material = 0);
/// Gives a contact friction and restitution of the materials that touch in it.
void mix_materials(Stores& world, std::uint32_t slot);

}  // namespace atl
