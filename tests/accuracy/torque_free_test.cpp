// Free rotation of bodies with unequal moments of inertia (Landau and Lifshitz, "Mechanics", sections 33 and 37):
// angular momentum and energy are constant, a symmetric top's axis turns about the angular momentum at |L| / I1.

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"

namespace atl::test::torque_free_test {
namespace {

constexpr double mass = 3;

struct Top {
  World world{WorldDef{.gravity = Vector3::Zero()}};
  BodyId id;
  Vector3 inertia;

  Top(const Vector3& half_extents, const Vector3& spin) : inertia(box_inertia(mass, half_extents)) {
    id = world.add_body({.shape = Box{half_extents}, .angular_velocity = spin, .mass = mass});
  }
  Vector3 body_spin() const { return world.pose(id).orientation.conjugate() * world.angular_velocity(id); }
  Vector3 angular_momentum() const { return world.pose(id).orientation * inertia.cwiseProduct(body_spin()); }
  double energy() const { return 0.5 * world.angular_velocity(id).dot(angular_momentum()); }
};

TEST(TorqueFree, AsymmetricBoxKeepsEnergyAndAngularMomentum) {
  // Near the axis of middle inertia, where the motion is richest.
  Top top({0.5, 0.3, 0.2}, {0.05, 4, 0.05});
  const double energy = top.energy();
  const Vector3 angular_momentum = top.angular_momentum();
  double energy_drift = 0, momentum_drift = 0;
  for (int i = 0; i < 600; ++i) {
    top.world.step(dt);
    energy_drift = std::max(energy_drift, std::abs(top.energy() / energy - 1));
    momentum_drift =
        std::max(momentum_drift, (top.angular_momentum() - angular_momentum).norm() / angular_momentum.norm());
  }
  EXPECT_LT(energy_drift, 1e-5);
  EXPECT_LT(momentum_drift, 1e-5);
}

TEST(TorqueFree, SpinAboutTheMiddleAxisFlipsAndAboutTheOthersDoesNot) {
  const Vector3 half(0.5, 0.3, 0.2);  // the moment about y is the middle one
  for (int axis = 0; axis < 3; ++axis) {
    Vector3 spin = Vector3::Constant(0.05);
    spin[axis] = 4;
    Top top(half, spin);
    bool flipped = false;
    for (int i = 0; i < 600; ++i) {
      top.world.step(dt);
      flipped = flipped || top.body_spin()[axis] < 0;
    }
    EXPECT_EQ(flipped, axis == 1) << "axis " << axis;
  }
}

/// Angle in rad between a precessing symmetric top's axis and the closed form after `duration`.
double precession_error(double step, double duration, double& phase) {
  Top top({0.5, 0.5, 0.1}, {2, 0, 3});
  const Vector3 angular_momentum = top.angular_momentum();
  phase = angular_momentum.norm() / top.inertia.x() * duration;
  run(top.world, static_cast<int>(std::lround(duration / step)), step);
  const Vector3 expected = Eigen::AngleAxisd(phase, angular_momentum.normalized()) * Vector3::UnitZ();
  const Vector3 axis = top.world.pose(top.id).orientation * Vector3::UnitZ();
  return std::atan2(axis.cross(expected).norm(), axis.dot(expected));
}

TEST(TorqueFree, SymmetricTopPrecessesAboutItsAngularMomentum) {
  // Rotation over a step is integrated to second order: a phase error of about (rate * step)^2 / 12 a radian. A method
  // of first order would be out by rate * step / 2 a radian, 1.5 rad here.
  double phase = 0;
  const double duration = 5;
  const double error = precession_error(dt, duration, phase);
  const double per_step = phase / duration * dt;
  EXPECT_LT(error, per_step * per_step / 12 * phase);
  EXPECT_LT(precession_error(dt / 2, duration, phase), error / 3.5 + 1e-9) << "halving the step quarters the error";
}

}  // namespace
}  // namespace atl::test::torque_free_test
