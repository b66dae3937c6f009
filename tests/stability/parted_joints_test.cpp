// Errors of position are undone without leaving speed: joints that begin beyond their ranges.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test::parted_joints_test {
namespace {

double fastest(const World& world, const std::vector<BodyId>& ids) {
  double most = 0;
  for (const BodyId id : ids) {
    most = std::max({most, world.velocity(id).norm(), world.angular_velocity(id).norm()});
  }
  return most;
}

// Rods that are straight, and hinges each of which is to be bent by half a radian at least. No two of them touch.
struct Chain {
  World world;
  std::vector<BodyId> rods;
  std::vector<JointId> hinges;

  Chain(int count, bool anchored, double armature, double damping, JointSolver solver)
      : world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}}) {
    const CollisionFilter none = {.category = 2, .mask = 1};
    const BodyType type = anchored ? BodyType::Static : BodyType::Dynamic;
    BodyId before = world.add_body({.type = type, .shape = Sphere{0.1}, .filter = none});
    for (int i = 0; i < count; ++i) {
      rods.push_back(world.add_body(
          {.shape = Box{{0.2, 0.03, 0.03}}, .position = {0.2 + 0.4 * i, 0, 0}, .mass = 1, .filter = none}));
      HingeJoint hinge;
      hinge.angle.range = i % 2 == 0 ? JointRange{0.5, 2} : JointRange{-2, -0.5};
      hinge.angle.armature = armature;
      if (damping > 0) hinge.angle.motor = JointMotor{.max_force = 10, .servo = JointServo{.damping = damping}};
      hinges.push_back(world.add_joint(joint_at(world, hinge, before, rods.back(), {0.4 * i, 0, 0}, Vector3::UnitY())));
      before = rods.back();
    }
  }
};

TEST(PartedJoints, CoordinatesComeBackIntoTheirRangesWithoutSpeed) {
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Direct}) {
    for (const bool anchored : {false, true}) {
      for (const double armature : {0.0, 0.1}) {
        for (const double damping : {0.0, 0.5}) {
          for (const int count : {1, 2, 4}) {
            Chain chain(count, anchored, armature, damping, solver);
            double most = 0;
            for (int i = 0; i < 60; ++i) {
              chain.world.step(dt);
              most = std::max(most, fastest(chain.world, chain.rods));
            }
            const std::string of = std::to_string(count) + " rods, anchored " + std::to_string(anchored) +
                                   ", armature " + std::to_string(armature) + ", damping " + std::to_string(damping);
            EXPECT_LT(most, 1e-4) << of;
            for (const JointId id : chain.hinges) {
              EXPECT_GT(std::abs(chain.world.joint_state(id).position[0]), 0.499) << of;
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace atl::test::parted_joints_test
