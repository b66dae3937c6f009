// Mechanisms of random trees, held against sums over the bodies of the world, numerical differentiation, and its steps.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "support/motion.h"
#include "support/random_tree.h"

namespace atl::test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class MechanismDynamics : public testing::TestWithParam<std::uint32_t> {
 protected:
  MechanismDynamics() : tree(GetParam(), GetParam() % 2 == 0), mechanism(tree.world, tree.base) {
    std::tie(q, v) = tree.random_state(mechanism);
    mechanism.set(q, v);
  }
  RandomTree tree;
  Mechanism mechanism;
  VectorXd q, v;
};

TEST_P(MechanismDynamics, TheWorldIsWhereItWasSet) {
  EXPECT_LT((mechanism.q() - q).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((mechanism.v() - v).cwiseAbs().maxCoeff(), 1e-12);
  std::vector<PlacedJoint> joints;
  std::vector<BodyState> states;
  for (const BodyId body : tree.world.bodies()) states.push_back(tree.world.state(body));
  for (const JointId id : tree.world.joints()) {
    const JointDef& def = tree.world.joint(id);
    joints.push_back({def.kind, def.first.index, def.second.index, def.frame_first, def.frame_second});
  }
  const JointDriftReport drift = measure_joint_drift(joints, states);
  EXPECT_LT(drift.max, 1e-12);
  EXPECT_LT(drift.angle_max, 1e-7) << "the audit's angles are as exact as arc cosines are";
}

TEST_P(MechanismDynamics, MassMatrixIsTheSumOverBodies) {
  const MatrixXd mass = mechanism.mass_matrix();
  MatrixXd sum = tree.armature(mechanism).asDiagonal();
  for (const BodyId body : tree.bodies) {
    const MatrixXd jacobian = mechanism.jacobian(body, tree.centre_in_frame(body));
    sum += tree.world.mass(body) * jacobian.topRows(3).transpose() * jacobian.topRows(3);
    sum += jacobian.bottomRows(3).transpose() * tree.inertia_of(body) * jacobian.bottomRows(3);
  }
  EXPECT_LT((mass - sum).cwiseAbs().maxCoeff(), 1e-11 * mass.cwiseAbs().maxCoeff());
  EXPECT_EQ(mass, mass.transpose());
  EXPECT_GT(mass.ldlt().vectorD().minCoeff(), 1e-6);
}

TEST_P(MechanismDynamics, JacobiansGiveTheVelocitiesOfBodies) {
  for (const BodyId body : tree.bodies) {
    const VectorXd velocity = mechanism.jacobian(body, tree.centre_in_frame(body)) * v;
    EXPECT_LT((velocity.head<3>() - tree.world.velocity(body)).norm(), 1e-12);
    EXPECT_LT((velocity.tail<3>() - tree.world.angular_velocity(body)).norm(), 1e-12);
  }
}

TEST_P(MechanismDynamics, EnergyAndMomentumAreThoseOfTheWorldsBodies) {
  const MotionReport motion = motion_of(tree.world);
  const double rotors = 0.5 * v.dot(tree.armature(mechanism).cwiseProduct(v));
  EXPECT_NEAR(mechanism.kinetic_energy(), motion.kinetic + rotors, 1e-11 * motion.kinetic);
  EXPECT_NEAR(mechanism.kinetic_energy(), 0.5 * v.dot(mechanism.mass_matrix() * v), 1e-11 * motion.kinetic);
  EXPECT_NEAR(mechanism.potential_energy(), motion.potential, 1e-10);
  double mass = 0;
  for (const BodyId body : tree.bodies) mass += tree.world.mass(body);
  const MechanismMomentum momentum = mechanism.momentum();
  const Vector3 about_origin = momentum.angular + mechanism.centre_of_mass().cross(momentum.linear);
  EXPECT_LT((momentum.linear - motion.momentum).norm(), 1e-11);
  EXPECT_LT((about_origin - motion.angular_momentum).norm(), 1e-10);
  EXPECT_LT((mass * mechanism.centre_of_mass_jacobian() * v - motion.momentum).norm(), 1e-11);
}

// d'Alembert's principle: tau does the work of m a - f on all bodies, whose accelerations are differences of
// velocities.
TEST_P(MechanismDynamics, InverseDynamicsIsDAlembertsOfDifferences) {
  const VectorXd acceleration = tree.random_vector(mechanism.nv(), 2);
  const VectorXd tau = mechanism.inverse_dynamics(acceleration);
  const VectorXd at_rest = mechanism.gravity();
  VectorXd sum = tree.armature(mechanism).cwiseProduct(acceleration);
  VectorXd weight = VectorXd::Zero(sum.size());
  constexpr double h = 1e-4;
  for (const BodyId body : tree.bodies) {
    const MatrixXd jacobian = mechanism.jacobian(body, tree.centre_in_frame(body));
    const Matrix3 inertia = tree.inertia_of(body);
    const Vector3 spin = tree.world.angular_velocity(body);
    const auto state_at = [&](double time) {
      mechanism.set(mechanism.integrate(q, time * v + 0.5 * time * time * acceleration), v + time * acceleration);
      return tree.world.state(body);
    };
    const BodyState after = state_at(h), before = state_at(-h);
    mechanism.set(q, v);
    const double mass = tree.world.mass(body);
    const Vector3 gravity = tree.world.definition(body).gravity_scale * tree.world.gravity();
    const Vector3 force = mass * ((after.velocity - before.velocity) / (2 * h) - gravity);
    const Vector3 torque =
        inertia * (after.angular_velocity - before.angular_velocity) / (2 * h) + spin.cross(inertia * spin);
    sum += jacobian.topRows(3).transpose() * force + jacobian.bottomRows(3).transpose() * torque;
    weight -= mass * jacobian.topRows(3).transpose() * gravity;
  }
  EXPECT_LT((tau - sum).cwiseAbs().maxCoeff(), 1e-5 * tau.cwiseAbs().maxCoeff());
  EXPECT_LT((at_rest - weight).cwiseAbs().maxCoeff(), 1e-10 * weight.cwiseAbs().maxCoeff());
  EXPECT_LT((tau - mechanism.mass_matrix() * acceleration - mechanism.bias()).norm(), 1e-10 * tau.norm());
}

TEST_P(MechanismDynamics, ForwardUndoesInverse) {
  const VectorXd acceleration = tree.random_vector(mechanism.nv(), 2);
  const VectorXd back = mechanism.forward_dynamics(mechanism.inverse_dynamics(acceleration));
  EXPECT_LT((back - acceleration).cwiseAbs().maxCoeff(), 1e-10);
}

TEST_P(MechanismDynamics, StepsAccelerateAsForwardDynamicsSays) {
  const VectorXd tau = tree.random_vector(mechanism.nv(), 2);
  const VectorXd expected = mechanism.forward_dynamics(tau);
  double errors[2];
  const double steps[] = {1e-3, 1e-4};
  for (int i = 0; i < 2; ++i) {
    mechanism.set(q, v);
    mechanism.apply(tau);
    tree.world.step(steps[i]);
    errors[i] = ((mechanism.v() - v) / steps[i] - expected).norm() / expected.norm();
  }
  EXPECT_LT(errors[0], 0.1);
  EXPECT_LT(errors[1], 0.15 * errors[0] + 1e-4) << "of first order in the step";
}

INSTANTIATE_TEST_SUITE_P(Random, MechanismDynamics, testing::Range(1u, 9u));

}  // namespace
}  // namespace atl::test
