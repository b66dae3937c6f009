#pragma once

#include <solver/integrate/motion.h>

#include <cstdint>

namespace atl::solver {

/// Moves a dynamic body that nothing touches, in double: exact for constant acceleration (semi-implicit Euler
/// would miss half a h^2 a step), exact for a spin about a fixed axis. With an anisotropic inertia the angular
/// momentum is held exactly and the orientation follows it to fourth order, by Magnus' series for its rotation vector
/// (Iserles and Norsett, "On the solution of linear differential equations in Lie groups", 1999). One that turns by more
/// than 200 rad in a step goes on as a SplitTop, and its energy is put right after each part. Damping acts at the end
/// of each substep, implicitly, as it does on bodies in contact.
void move_free_body(BodyTable& bodies, std::uint32_t body, const Vector3& gravity, double dt, int substeps,
                    collision::MotionBounds& bounds, FastBodies& fast);

/// Torque-free rotation in steps of any size: that of a symmetric top, which two rotations give exactly, and between
/// halves of it the small rest, by which the other two moments differ from their mean (McLachlan, "Explicit Lie-Poisson
/// integration and the Euler equations", 1993). Momentum is kept, and so is energy, but for that rest to second order.
class SplitTop {
 public:
  SplitTop() = default;
  SplitTop(const Vector3& moments, const Quaternion& principal);

  /// The orientation after h seconds. Momentum in N m s, world frame.
  Quaternion turned(const Quaternion& start, const Vector3& momentum, double h) const;
  /// The same, with the spin; the inverse inertia is the body's.
  void turn(const Matrix3& inverse_inertia, const Vector3& momentum, double h, Quaternion& orientation,
            Vector3& spin) const;

 private:
  int axis_ = 0;
  double across_ = 0, along_ = 0, rest_ = 0;  // 1/(kg m^2)
  Quaternion principal_ = Quaternion::Identity();
  Vector3 own_axis_ = Vector3::Zero();  // of the top, in the body's frame
};

/// The pose that a kinematic body, or a static one, has after `time` seconds at its velocities.
BodyPose pose_after(const BodyTable& bodies, std::uint32_t body, double time);

/// Moves a kinematic body at its velocities.
void move_kinematic_body(BodyTable& bodies, std::uint32_t body, double dt, collision::MotionBounds& bounds,
                         FastBodies& fast);

/// Rotation by a rotation vector (rad).
Quaternion rotation_by(const Vector3& rotation_vector);

/// Puts a body to an orientation that it had before. The spin of a tumbling body turns along, which keeps its energy.
void turn_back(BodyTable& bodies, std::uint32_t body, const Quaternion& orientation);

}  // namespace atl::solver
