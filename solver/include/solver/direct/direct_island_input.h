#pragma once

#include <collision/contacts/contact.h>
#include <collision/shapes/collider_table.h>
#include <solver/constraints/contact_capture.h>
#include <solver/constraints/joint.h>
#include <solver/constraints/surface_contact.h>
#include <solver/integrate/motion.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

namespace atl::solver {

/// Stands for the impulse of a contact that hasn't pushed in a step.
inline constexpr float not_pushed = -1;

/// The input of a direct solve of an island, with references to the results that it writes.
struct DirectIslandInput {
  const Islands& islands;
  BodyTable& bodies;
  collision::ContactManifold* manifolds;  ///< by slot
  Vector3 gravity;                        ///< m/s^2
  double dt;                              ///< s
  const SolverSettings& settings;
  collision::MotionBounds& bounds;  ///< of what the bodies move by
  FastBodies& fast;
  const collision::Contact* contacts = nullptr;  ///< by slot; null, as the colliders, where nothing touches
  const collision::ColliderTable* colliders = nullptr;
  ContactCapture* capture = nullptr;  ///< null where nobody asks
  /// The normal impulse of each contact slot in the step, N s; not_pushed if it had none. Null if not asked for.
  float* pushed = nullptr;
  SurfaceContact* surface_contacts = nullptr;  ///< by contact slot; null while all surfaces are plain
  const AddedSlip* added_slips = nullptr;      ///< by contact slot; null where nobody adds any
  Joint* joints = nullptr;                     ///< by index of joint

  const AddedSlip* added_slip(std::uint32_t slot) const { return added_slips ? added_slips + slot : nullptr; }
  /// s, of a substep.
  double substep() const { return dt / settings.substeps; }
};

}  // namespace atl::solver
