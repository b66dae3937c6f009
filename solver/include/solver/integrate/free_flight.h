#pragma once

#include <solver/integrate/motion.h>

#include <cstdint>

namespace atl::solver {

/// Moves a dynamic body that nothing touches, in double: exact for constant acceleration (semi-implicit Euler
/// would miss half a h^2 a step), exact for a spin about a fixed axis. With an anisotropic inertia the angular
/// momentum is held exactly and the orientation follows it to fourth order, by Magnus' series for its rotation vector
/// (Iserles and Norsett, "On the solution of linear differential equations in Lie groups", 1999). Damping acts at the
/// end of each substep, implicitly, as it does on bodies in contact.
void move_free_body(BodyTable& bodies, std::uint32_t body, const Vector3& gravity, double dt, int substeps,
                    collision::MotionBounds& bounds, FastBodies& fast);

/// The pose that a kinematic body, or a static one, has after `time` seconds at its velocities.
BodyPose pose_after(const BodyTable& bodies, std::uint32_t body, double time);

/// Moves a kinematic body at its velocities.
void move_kinematic_body(BodyTable& bodies, std::uint32_t body, double dt, collision::MotionBounds& bounds,
                         FastBodies& fast);

/// Rotation by a rotation vector (rad).
Quaternion rotation_by(const Vector3& rotation_vector);

}  // namespace atl::solver
