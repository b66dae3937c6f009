#pragma once
/// Bodies as they come, go and are changed from outside, in all stores at once.

#include <cstdint>
#include <memory>
#include <string_view>

#include "world/stores.h"

namespace atl {

BodyId add_body(Stores& world, const CheckedBody& start);
void remove_body(Stores& world, std::uint32_t body);
/// Makes room for so many bodies in all stores.
void resize_bodies(Stores& world, std::size_t count);
/// Tells all stores what a body is for as long as it lives.
void give_constants(Stores& world, std::uint32_t body, const std::shared_ptr<const BodyConstants>& constants);
/// Takes a body out of all that a step goes through, but for its joints, which go before. What touched it wakes.
void take_out(Stores& world, std::uint32_t body);
/// The contacts of a body, what they carried, and what a contact filter said of them.
void forget_contacts(Stores& world, std::uint32_t body);

inline BodyId id_of(const Stores& world, std::uint32_t body) { return {body, world.records.generation[body]}; }
bool contains(const Stores& world, BodyId id);
/// Throws Error that names `call` if no body has the id.
std::uint32_t index_of(const Stores& world, BodyId id, const char* call);
/// See World::definition().
BodyDef definition_of(const Stores& world, std::uint32_t body);
/// The pose of the body's frame.
Pose pose_of(const Stores& world, std::uint32_t body);

/// A body's velocity or forces were, or will be, changed: it wakes, and the next step checks it. Returns the body.
std::uint32_t awaken(Stores& world, std::uint32_t body);
void wake_all(Stores& world);
void wake_touching(Stores& world, std::uint32_t body);

void apply_force(Stores& world, std::uint32_t body, const Vector3& force, const Vector3& torque);  // N, N m
void clear_forces(Stores& world);
void apply_impulse(Stores& world, std::uint32_t body, const Vector3& impulse, const Vector3& moment);  // N s, N m s
/// Throws Error if its velocities would not be finite after that.
void check_impulse(const Stores& world, std::uint32_t body, const Vector3& impulse, const Vector3& moment);
void set_pose(Stores& world, std::uint32_t body, const Vector3& origin, const Quaternion& orientation);
/// Lets the surface run along the body; what holds back rolling is the material's.
void run_surface(Stores& world, std::uint32_t body, const solver::SurfaceMotion& motion);
solver::SurfaceMotion surface_motion(const Stores& world, std::uint32_t body);
/// The same of a body that others may lie on: they wake.
void set_surface_velocity(Stores& world, std::uint32_t body, const solver::SurfaceMotion& motion);
/// Stores other constants of a body, with shapes of the same kinds and the same centre of mass. Nothing follows yet.
void exchange_constants(Stores& world, std::uint32_t body, const BodyConstants& constants);
/// Gives a body other constants, with the same shapes and centre of mass. What is joined to it is solved anew.
void change_constants(Stores& world, std::uint32_t body, const BodyConstants& constants);
void give_name(Stores& world, std::uint32_t body, std::string_view name);
void set_filter(Stores& world, std::uint32_t body, const CollisionFilter& filter);
/// Has the next step ask a contact filter again of what is near a body.
void refilter(Stores& world, std::uint32_t body);
void set_collision_enabled(Stores& world, std::uint32_t first, std::uint32_t second, bool enabled);

/// Who may move may have changed by that.
void mark_arrival_or_departure(Stores& world, std::uint32_t body);
/// Follows what fell asleep, woke, came, went or got a velocity, and which contacts are looked at by that. Whether the
/// active bodies changed.
struct ActiveChange {
  bool changed = false;
  std::span<const std::uint32_t> woken_contacts;  ///< slots, valid until the next change of contacts
};
ActiveChange update_active_bodies(Stores& world);

}  // namespace atl
