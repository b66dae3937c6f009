#pragma once
/// Dynamics of a mechanism at a state, in spatial vectors.

#include <vector>

#include "mechanism/kinematics.h"

namespace atl::mechanism {

/// Masses of the bodies, at their poses.
struct Weights {
  std::vector<Matrix6> inertia;  ///< spatial, by link, about the origin of the kinematics
  std::vector<Vector3> centre;   ///< m, world frame
  std::vector<double> mass;      ///< kg
  std::vector<Vector3> gravity;  ///< m/s^2, that each feels
  VectorXd armature;             ///< by v

  double total() const;           ///< kg
  Vector3 centre_of_all() const;  ///< m, world frame
};

Weights weights(const Tree& tree, const World& world, const Kinematics& at);

MatrixXd mass_matrix(const Tree& tree, const Kinematics& at, const Weights& weights);

/// The tau for accelerations v'.
VectorXd inverse_dynamics(const Tree& tree, const Kinematics& at, const Weights& weights, const VectorXd& acceleration);

MechanismMomentum momentum(const Kinematics& at, const Weights& weights);

}  // namespace atl::mechanism
