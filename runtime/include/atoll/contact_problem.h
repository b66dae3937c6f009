#pragma once

#include <atoll/types.h>

#include <cstddef>
#include <vector>

namespace atl {

/// The discrete contact problem of the last substep of a step (of all of it, where contacts were solved at once), as
/// rigid contact has it, and the impulses that the
/// solver answered with: enough to judge the answer, or to find another one.
///
/// Find impulses such that the velocities after them, v = free + M^-1 J^T r, obey, with u the relative velocity of the
/// second body against the first at a patch:
///   at each point i    0 <= u_n,i + max(gap_i, 0) / h   perpendicular to   r_i >= 0
///   at each patch      |r_T| <= mu R,        r_T opposite to u_T + slip where it slides,    R the sum of its r_i
///                      |r_w| <= (mu L + t) R,  r_w opposite to the spin u_w where it twists
///                      |r_r| <= p R,         r_r opposite to the tangential spin where it rolls
struct ContactProblem {
  static constexpr std::size_t fixed = static_cast<std::size_t>(-1);

  /// A body that contacts can move, or that moves as it is told.
  struct Body {
    std::size_t index = 0;                            ///< BodyId::index
    double inverse_mass = 0;                          ///< 1/kg; 0 for a kinematic body
    Vector3 free_axes = Vector3::Ones();              ///< 1, or 0 along axes of the world along which it is locked
    Matrix3 inverse_inertia = Matrix3::Zero();        ///< 1/(kg m^2), world frame
    Vector3 free_velocity = Vector3::Zero();          ///< m/s, after forces and before contact impulses
    Vector3 free_angular_velocity = Vector3::Zero();  ///< rad/s
  };

  struct Point {
    double x = 0, y = 0;  ///< m, from the patch's centre along its tangents
    double gap = 0;       ///< m, as the substep ends its positions; negative where the shapes overlap
    double impulse = 0;   ///< N s, on the second body along the normal
  };

  /// Points of contact between two bodies that share a normal. Friction acts at the centre.
  struct Patch {
    std::size_t first = fixed;  ///< index into `bodies`, or `fixed`
    std::size_t second = fixed;
    Vector3 normal;        ///< unit, from the first to the second
    Vector3 tangent;       ///< unit; the other one is normal x tangent
    Vector3 anchor_first;  ///< m, world axes, of the centre from the first body's centre of mass
    Vector3 anchor_second;
    double friction = 0;  ///< mu
    /// Unit, in the tangent plane: friction is mu along it, and `friction_ratio` mu across it. r_T is then measured,
    /// and u_T too, in axes of which the second is `friction_ratio` times as long. Zero: alike in all directions.
    Vector3 friction_axis = Vector3::Zero();
    double friction_ratio = 1;
    double radius = 0;                           ///< m, L: the arm of friction against twisting
    double torsional_friction = 0;               ///< m, t
    double rolling_friction = 0;                 ///< m, p
    Vector3 slip = Vector3::Zero();              ///< m/s: how fast the second surface runs against the first
    Vector3 spin = Vector3::Zero();              ///< rad/s: how fast the second surface turns against the first
    std::vector<Point> points = {};              ///< one to four
    Vector3 friction_impulse = Vector3::Zero();  ///< N s, tangential, on the second body at the centre
    double torsional_impulse = 0;                ///< N m s, about the normal, on the second body
    Vector3 rolling_impulse = Vector3::Zero();   ///< N m s, in the tangent plane, on the second body
    double step = 0;                             ///< s, h of this patch, where it is not `substep`; else 0
  };

  double substep = 0;  ///< s, h
  std::vector<Body> bodies;
  std::vector<Patch> patches;
};

}  // namespace atl
