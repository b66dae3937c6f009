#pragma once
/// Poses and motions of the bodies of a mechanism, from its coordinates.

#include <Eigen/Core>
#include <vector>

#include "mechanism/tree.h"

namespace atl::mechanism {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix6X = Eigen::Matrix<double, 6, Eigen::Dynamic>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Spatial vectors, as Featherstone has them: of a motion the angular part and the velocity at the origin, of a force
/// the moment about the origin and the force; in the world's axes.
struct Kinematics {
  Vector3 origin = Vector3::Zero();    ///< m, world frame: a fixed point near the tree
  std::vector<Pose> poses = {};        ///< of the links' bodies
  Matrix6X axes = {};                  ///< by v: the motion of the link against its parent at a rate of 1
  std::vector<Vector6> velocity = {};  ///< of the links
  std::vector<Vector6> drift = {};     ///< accelerations of the links with v' = 0
};

Pose product(const Pose& a, const Pose& b);
Pose inverse(const Pose& a);

/// Motion x motion: the rate of a spatial vector that moves with `velocity`. Featherstone, (2.31).
Vector6 cross_motion(const Vector6& velocity, const Vector6& motion);
/// Motion x force. Featherstone, (2.32).
Vector6 cross_force(const Vector6& velocity, const Vector6& force);

VectorXd read_q(const Tree& tree, const World& world);
VectorXd read_v(const Tree& tree, const World& world);

/// A fixed base is where the world has it, and moves as it does there. Quaternions of q are unit ones.
Kinematics kinematics(const Tree& tree, const World& world, const VectorXd& q, const VectorXd& v);

/// q after a step v, quaternions normalised.
VectorXd integrate(const Tree& tree, const VectorXd& q, const VectorXd& v);

/// 6 x nv: linear and angular velocity of a point (m, world frame) that is fixed to a link.
MatrixXd jacobian_at(const Tree& tree, const Kinematics& at, std::size_t link, const Vector3& point);

/// The velocity of a point (m, world frame) that moves so.
inline Vector3 velocity_at(const Kinematics& at, const Vector6& velocity, const Vector3& point) {
  return velocity.tail<3>() + velocity.head<3>().cross(point - at.origin);
}

}  // namespace atl::mechanism
