// Forces and impulses on a free body. A force is constant over its step, so velocity and position have closed forms.

#include <gtest/gtest.h>

#include "support/bodies.h"

namespace atl::test::applied_force_test {
namespace {

constexpr double rounding = 1e-12;

TEST(AppliedForce, AcceleratesOverTheNextStepOnly) {
  World world({.gravity = Vector3::Zero()});
  const BodyId id = world.add_body({.shape = Sphere{0.5}, .mass = 4.0});
  const Vector3 force(8, -12, 20);
  world.apply_force(id, force / 2);
  world.apply_force(id, force / 2);
  world.step(dt);
  const Vector3 velocity = force / 4 * dt;
  EXPECT_LT((world.velocity(id) - velocity).norm(), rounding * velocity.norm());
  EXPECT_LT((world.pose(id).position - velocity * dt / 2).norm(), rounding);

  world.step(dt);
  EXPECT_LT((world.velocity(id) - velocity).norm(), rounding * velocity.norm());
  EXPECT_LT((world.pose(id).position - velocity * dt * 1.5).norm(), rounding);
}

TEST(AppliedForce, TorqueSpinsASphereUpByItsInertia) {
  World world({.gravity = Vector3::Zero()});
  const double mass = 5, radius = 0.4;
  const BodyId id = world.add_body({.shape = Sphere{radius}, .mass = mass});
  const Vector3 torque(1, 2, -3);
  world.apply_force(id, Vector3::Zero(), torque);
  world.step(dt);
  const Vector3 spin = torque / (0.4 * mass * radius * radius) * dt;
  // Inertia is inverted once, in single precision at worst.
  EXPECT_LT((world.angular_velocity(id) - spin).norm(), 1e-6 * spin.norm());
}

TEST(AppliedForce, ImpulseOffTheCentreTurnsABox) {
  World world({.gravity = Vector3::Zero()});
  const Vector3 half(0.5, 0.3, 0.2);
  const double mass = 12;
  const Quaternion turn(Eigen::AngleAxisd(0.6, Vector3(1, -1, 2).normalized()));
  const Vector3 centre(3, 2, 1);
  const BodyId id = world.add_body({.shape = Box{half}, .position = centre, .orientation = turn, .mass = mass});
  const Vector3 arm(0.1, 0.2, -0.3), impulse(4, -5, 6);
  world.apply_impulse(id, impulse, centre + arm);

  const Vector3 spin = turn * (turn.conjugate() * arm.cross(impulse)).cwiseQuotient(box_inertia(mass, half));
  EXPECT_LT((world.velocity(id) - impulse / mass).norm(), 1e-6 * impulse.norm() / mass);
  EXPECT_LT((world.angular_velocity(id) - spin).norm(), 1e-6 * spin.norm());
}

TEST(AppliedForce, GivenInertiaReplacesTheShapes) {
  World world({.gravity = Vector3::Zero()});
  const Matrix3 inertia = Vector3(2, 3, 4).asDiagonal();
  const BodyId id = world.add_body({.shape = Box{}, .mass = 10.0, .inertia = inertia});
  world.apply_impulse(id, {0, 0, 6}, {0, 1, 0});
  EXPECT_LT((world.angular_velocity(id) - Vector3(3, 0, 0)).norm(), 1e-6 * 3);
}

}  // namespace
}  // namespace atl::test::applied_force_test
