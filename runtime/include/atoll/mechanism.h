#pragma once

#include <atoll/joint.h>
#include <atoll/types.h>

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace atl {

class World;

namespace mechanism {
struct Tree;
}

/// The places of a joint's coordinates in the arrays of a Mechanism. The numbers of q and of v differ for a ball and a
/// free base, and are 0 for a joint without a free coordinate.
struct MechanismJoint {
  JointId joint = {};     ///< no joint's id, for a free base
  std::string name = {};  ///< the joint's, or the body's for a free base
  BodyId body = {};       ///< the one that it carries
  std::size_t q = 0;      ///< the first place in q
  std::size_t q_count = 0;
  std::size_t v = 0;  ///< the first place in v, tau and the rows of the mass matrix
  std::size_t v_count = 0;
};

/// Linear and angular momentum.
struct MechanismMomentum {
  Vector3 linear = Vector3::Zero();   ///< kg m/s
  Vector3 angular = Vector3::Zero();  ///< kg m^2/s, about the centre of mass
};

/// Result of Mechanism::inverse_kinematics().
struct InverseKinematics {
  Eigen::VectorXd q;          ///< nq numbers: for Mechanism::set()
  double position_error = 0;  ///< m, from the point to its target
  double angle_error = 0;     ///< rad, from the body's orientation to its target; 0 where none is given
  int iterations = 0;
};

/// A tree of joints and bodies in generalised coordinates, for control and planning: its kinematics and dynamics at the
/// state in which the world is when asked.
///
/// Coordinates, q (nq numbers) and their rates, v (nv numbers), are in this order: those of a free base, and then those
/// of the joints in order of their indices, which is that in which they were added while none was removed.
///   free base   q: the origin of the body's frame (m, world frame), its orientation (x, y, z, w)
///               v: velocity of that origin (m/s) and angular velocity (rad/s), in the world's axes
///   hinge       q: rad; v: rad/s
///   slider      q: m; v: m/s
///   universal, wheel: their coordinates as JointState has them, without a wheel's steering if that is locked
///   six-dof     its offsets that are not locked, as a slider's; and a ball's if none of its turns is locked
///   ball        q: orientation of the second frame in the first (x, y, z, w)
///               v: angular velocity of the second body against the first (rad/s), in the axes of the first frame
///   fixed       none
/// A coordinate that is locked by its range stays at that value and is no coordinate here. Generalised forces, tau, are
/// those that do work with v: N or N m each.
///
/// Coordinates are read as World measures them. All else follows from them by exact kinematics of the joints, so the
/// little by which joints of the world are open doesn't show. The quantities are those of the bodies, joints, armatures
/// and gravity alone. Springs, motors, ranges, friction, damping, contacts, tendons, and joints in loops() are not
/// among them: as far as they act, their forces are part of tau.
///
/// All in double, by Featherstone, "Rigid Body Dynamics Algorithms", 2008, with spatial vectors in the world's axes.
///
/// Calls throw Error if a body or joint of the tree was removed, disabled, broken or put into quarantine since, if
/// another joint was added to a body of it, a body was given motion locks, which coordinates know nothing of, or if a
/// coordinate was locked or unlocked: make another then. They throw it
/// too on arrays of another size, on numbers that are not finite, and on bodies that aren't in the tree. A world must
/// outlive its mechanisms, and stay where it is: they refer to it.
class Mechanism {
 public:
  /// Takes the enabled joints that hang together with `base`, up to bodies that are not dynamic.
  ///
  /// A base that is static or kinematic is a fixed one, and all that hangs on it is in the tree. From a dynamic body,
  /// the base is what carries it: the body that isn't dynamic of the joint with the lowest index to such a body, and
  /// without one the body itself, which is then a free base. From the base the tree goes on breadth first, through the
  /// joints of each body in order of their indices. Joints that close a loop are left out, as are gears and distance
  /// joints: see loops().
  ///
  /// Throws Error on a stale id; on a body in quarantine; on a base on which nothing hangs; and on a joint of a kind
  /// that has other coordinates (ConeTwistJoint, SixDofJoint with SixDofTurns::Vector of which some but not all turns
  /// are locked, or one is at another value than 0 or has an armature), which it names.
  Mechanism(World& world, BodyId base);

  std::size_t nq() const;
  std::size_t nv() const;
  bool is_floating() const;  ///< true if the base is free
  BodyId base() const;
  /// Dynamic ones, from the base on: each after the one that carries it.
  const std::vector<BodyId>& bodies() const;
  /// In order of their coordinates. A free base is the first.
  const std::vector<MechanismJoint>& joints() const;
  /// Joints on bodies of the tree that are not in it, in order: those that close a loop, and gears and distance joints.
  const std::vector<JointId>& loops() const;

  Eigen::VectorXd q() const;
  Eigen::VectorXd v() const;
  /// Puts all bodies where q has them, and gives them the velocities that follow from v. Quaternions of q are
  /// normalised, and must not be 0. A fixed base stays. Values beyond a range are taken as they are.
  void set(const Eigen::VectorXd& q, const Eigen::VectorXd& v);
  /// The configuration after a step v (m or rad) from q: q + v where these are numbers, a turn by the vector of a
  /// ball's or free base's where they are quaternions.
  Eigen::VectorXd integrate(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;
  /// Adds generalised forces to what acts in the next step, as World::apply_force() does: on the body that each joint
  /// carries, and against it on the one that carries it. They keep their directions in space during that step.
  void apply(const Eigen::VectorXd& tau);

  /// nv x nv, kg, kg m or kg m^2, symmetric, with armatures. Composite rigid bodies: Featherstone, section 6.2.
  Eigen::MatrixXd mass_matrix() const;
  /// The tau at v' = 0: Coriolis and centrifugal forces, less those of gravity. Recursive
  /// Newton-Euler: Featherstone, section 5.3.
  Eigen::VectorXd bias() const;
  /// The tau that holds the tree still against gravity: bias() at v = 0.
  Eigen::VectorXd gravity() const;
  /// The tau for these accelerations v': mass_matrix() v' + bias(), without the matrix.
  Eigen::VectorXd inverse_dynamics(const Eigen::VectorXd& acceleration) const;
  /// The v' that follows from tau: mass_matrix()^-1 (tau - bias()).
  Eigen::VectorXd forward_dynamics(const Eigen::VectorXd& tau) const;

  /// 6 x nv: the velocity (m/s, 3 rows) of a point (m) of the body's frame and the angular velocity (rad/s) of the
  /// body, both in the world's axes, are J v while the base rests.
  Eigen::MatrixXd jacobian(BodyId body, const Vector3& point = Vector3::Zero()) const;
  Vector3 centre_of_mass() const;                   ///< m, world frame
  Eigen::MatrixXd centre_of_mass_jacobian() const;  ///< 3 x nv
  MechanismMomentum momentum() const;
  double kinetic_energy() const;    ///< J, with that of armatures: v' M v / 2 while the base rests
  double potential_energy() const;  ///< J, of gravity, against the world's origin

  /// Looks for a q that takes a point (m) of the body's frame to a target (m, world frame), and its orientation to the
  /// other target if there is one. It starts from where the world is, moves nothing, leaves a free base where it is,
  /// and keeps to the ranges of hinges, sliders and the like. A metre of the error weighs as much as a radian. It ends
  /// in the local minimum of the error that it comes to first; what is left of the error tells whether that is the
  /// target. Damped least squares: Buss, "Introduction to inverse kinematics with Jacobian transpose, pseudoinverse and
  /// damped least squares methods", 2004, section 6, with damping after Marquardt, 1963.
  InverseKinematics inverse_kinematics(BodyId body, const Vector3& point, const Vector3& target,
                                       const std::optional<Quaternion>& orientation = {}) const;

 private:
  World* world_;
  std::shared_ptr<const mechanism::Tree> tree_;
};

}  // namespace atl
