// Torque-free motion of bodies with unequal moments of inertia in the kernels (Landau and Lifshitz, "Mechanics",
// section 36): angular momentum and kinetic energy are constant, whatever the spin.

#include <gtest/gtest.h>
#include <solver/sweep/kernels.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

constexpr double h = 1.0 / 240;
const Vector3 moment(1, 2, 3.5);  // kg m^2
const Quaternion axes = Quaternion(0.3, 0.5, -0.7, 0.4).normalized();

struct Tumbler {
  SolverBodies bodies;
  SubstepConstants constants = SubstepConstants::of({.substeps = 1}, h);
  std::size_t body = 1;

  explicit Tumbler(const Vector3& spin) {
    bodies.reset(3, {.gyroscopic = true});
    bodies.gyroscopic[body] = GyroscopicRows::of(axes, moment);
    for (int k = 0; k < 3; ++k) bodies.velocity[body].angular[k] = static_cast<float>(spin[k]);
    std::copy_n(bodies.velocity[body].angular, 3, bodies.free_velocity[body].angular);
  }
  void run(const Kernels& kernels, int substeps) {
    for (int i = 0; i < substeps; ++i) {
      kernels.integrate_positions(bodies, constants, 0, bodies.padded_count());
    }
  }
  Vector3 spin() const { return Eigen::Map<const Eigen::Vector3f>(bodies.velocity[body].angular).cast<double>(); }
  Quaternion orientation() const {
    const float(&q)[4] = bodies.displacement[body].rotation;
    return Quaternion(q[3], q[0], q[1], q[2]) * axes;
  }
  Vector3 momentum() const {
    return orientation() * moment.cwiseProduct(Vector3(orientation().conjugate() * spin())).eval();
  }
  double energy() const { return 0.5 * spin().dot(momentum()); }
};

class TumblingTest : public testing::TestWithParam<const Kernels*> {};

TEST_P(TumblingTest, KeepsAngularMomentumAndEnergy) {
  Tumbler tumbler({3, -2, 5});
  const Vector3 momentum = tumbler.momentum();
  const double energy = tumbler.energy();
  for (int i = 0; i < 240; ++i) {
    tumbler.run(*GetParam(), 1);
    // A turn of 0.026 rad a substep: the method's own error is below 1e-8 of the momentum, single precision's is not.
    ASSERT_LT((tumbler.momentum() - momentum).norm(), 5e-5 * momentum.norm()) << i;
    ASSERT_NEAR(tumbler.energy(), energy, 5e-5 * energy) << i;
  }
  EXPECT_GT((tumbler.spin() - Vector3(3, -2, 5)).norm(), 0.5) << "it tumbles";
}

TEST_P(TumblingTest, IsNoConstraintsImpulse) {
  Tumbler tumbler({3, -2, 5});
  tumbler.run(*GetParam(), 10);
  const Vector3 free = Eigen::Map<const Eigen::Vector3f>(tumbler.bodies.free_velocity[1].angular).cast<double>();
  EXPECT_LT((free - tumbler.spin()).norm(), 1e-5);
}

TEST_P(TumblingTest, SpinOfAnySpeedGainsNoEnergy) {
  for (const double speed : {1e2, 1e4, 1e6}) {
    Tumbler tumbler(speed * Vector3(0.6, 0.01, 0.8));
    const double energy = 0.5 * tumbler.spin().dot(tumbler.momentum());
    for (int i = 0; i < 100; ++i) {
      tumbler.run(*GetParam(), 1);
      const Vector3 about_axes = tumbler.orientation().conjugate() * tumbler.spin();
      ASSERT_NEAR(0.5 * moment.dot(about_axes.cwiseAbs2()), energy, 1e-3 * energy) << speed << ", substep " << i;
    }
  }
}

TEST_P(TumblingTest, LeavesBodiesWithEqualMomentsAlone) {
  Tumbler tumbler({3, -2, 5});
  tumbler.bodies.velocity[2].angular[1] = 4;
  tumbler.bodies.velocity[2].inertia_xx = 7;
  tumbler.run(*GetParam(), 5);
  EXPECT_EQ(tumbler.bodies.velocity[2].angular[1], 4.0f);
  EXPECT_EQ(tumbler.bodies.velocity[2].inertia_xx, 7.0f);
  EXPECT_EQ(tumbler.bodies.free_velocity[2].angular[1], 0.0f);
  const float(&q)[4] = tumbler.bodies.displacement[2].rotation;
  EXPECT_NEAR(2 * std::atan2(q[1], q[3]), 5 * 4 * h, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Sets, TumblingTest, testing::ValuesIn(available_kernels()),
                         [](const auto& sets) { return sets.param->name; });

}  // namespace
}  // namespace atl::solver
