#pragma once

#include <collision/contacts/contact.h>
#include <collision/contacts/touching_pair.h>
#include <solver/integrate/body_table.h>

namespace atl::solver {

/// Surface effects of a touching pair beyond plain friction, by contact slot, in rows of four floats for the kernels.
/// The step sets all members but the impulse (the solver's caller sets the frictions, the solver how surfaces run). The
/// impulse lasts from step to step like a manifold's, but only while the contact has_impulse() and has rolling
/// friction: an impulse left by a former contact of the slot, or by another material, must not act on the next one.
struct alignas(32) SurfaceContact {
  /// m/s, world frame, at the contact: of the second surface along its body, against the first along its own.
  float slip[3] = {0, 0, 0};
  float rolling_friction = 0;            ///< m
  float rolling_impulse[3] = {0, 0, 0};  ///< N m s, in the tangent plane, on the second body
  float torsional_friction = 0;          ///< m
  float spin[3] = {0, 0, 0};             ///< rad/s, world frame: how the second surface turns so
  float twist = 1;                       ///< of the manifold's friction radius, that counts
  /// World frame: along the direction of most friction, as long as its part of the manifold's friction. Zero where
  /// friction is alike in all directions.
  float grip[3] = {0, 0, 0};
  float ratio = 1;  ///< of the friction across that direction, to that along it
};

/// True if its friction depends on the direction.
inline bool is_uneven(const SurfaceContact& contact) {
  return contact.grip[0] != 0 || contact.grip[1] != 0 || contact.grip[2] != 0;
}

/// True if a contact carried a load in the last step.
inline bool has_impulse(const collision::ContactManifold& manifold) {
  for (const float impulse : manifold.normal_impulse) {
    if (impulse != 0) return true;
  }
  return false;
}

/// How fast a body's surface runs along it, m/s, world frame, at an arm from its centre of mass (m, likewise).
Vector3 surface_velocity_at(const BodyTable& bodies, std::uint32_t body, const Vector3& arm);
/// rad/s, world frame.
Vector3 surface_spin(const BodyTable& bodies, std::uint32_t body);

/// A slip that is added to what bodies' surfaces make of it: m/s, world frame.
struct AddedSlip {
  float velocity[3] = {0, 0, 0};
};

/// Sets the surface effects of a touching pair in this step. Returns true if they are more than plain friction. `added`
/// may be null. `ahead`: s, from the step's begin to when velocities are to be those of the surfaces.
bool update_surface_contact(const collision::TouchingPair& pair, const BodyTable& bodies,
                            const collision::ContactManifold& manifold, double ahead, const AddedSlip* added,
                            SurfaceContact& contact);

}  // namespace atl::solver
