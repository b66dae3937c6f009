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

class JointGraph;
class JointSystems;
struct Kernels;

/// Stands for the impulse of a contact that hasn't pushed in a step.
inline constexpr float not_pushed = -1;

/// By how much the forces on bodies have changed: three numbers a body of the world.
struct ForceChange {
  const double* force;   ///< N
  const double* torque;  ///< N m
};

/// The input shared by all islands of a step, with references to the results that their solvers write.
struct SolveInput {
  const Islands& islands;
  BodyTable& bodies;
  collision::ContactManifold* manifolds;  ///< by slot
  Vector3 gravity;                        ///< m/s^2
  double dt;                              ///< s
  const SolverSettings& settings;
  const Kernels& kernels;
  collision::MotionBounds& bounds;  ///< of what the bodies move by
  FastBodies& fast;
  const collision::Contact* contacts = nullptr;  ///< by slot; null, as the colliders, where nothing touches
  const collision::ColliderTable* colliders = nullptr;
  ContactCapture* capture = nullptr;  ///< null where nobody asks
  /// The normal impulse of each contact slot in the step, N s; not_pushed if it had none. Null if not asked for.
  float* pushed = nullptr;
  SurfaceContact* surface_contacts = nullptr;  ///< by contact slot; null while all surfaces are plain
  const AddedSlip* added_slips = nullptr;      ///< by contact slot; null where nobody adds any
  const float* rises = nullptr;                ///< m, by contact slot (ContactCache::rises); null where there are none
  Joint* joints = nullptr;                     ///< by index of joint
  const JointGraph* joint_graph = nullptr;     ///< null where there are none
  JointSystems* joint_systems = nullptr;       ///< likewise

  const AddedSlip* added_slip(std::uint32_t slot) const { return added_slips ? added_slips + slot : nullptr; }
  /// s, of a substep.
  double substep() const { return dt / settings.substeps; }
  /// True if a component of joints is solved at once (joint_systems.h).
  bool solves_directly(std::uint32_t component) const;
};

}  // namespace atl::solver
