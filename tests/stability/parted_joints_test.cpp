// Errors of position are undone without leaving speed: joints that begin beyond their ranges, and shapes that overlap
// where joints don't let them part.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test::parted_joints_test {
namespace {

double fastest(const World& world, const std::vector<BodyId>& ids) {
  double max = 0;
  for (const BodyId id : ids) {
    max = std::max({max, world.velocity(id).norm(), world.angular_velocity(id).norm()});
  }
  return max;
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
            double max = 0;
            for (int i = 0; i < 60; ++i) {
              chain.world.step(dt);
              max = std::max(max, fastest(chain.world, chain.rods));
            }
            const std::string of = std::to_string(count) + " rods, anchored " + std::to_string(anchored) +
                                   ", armature " + std::to_string(armature) + ", damping " + std::to_string(damping);
            EXPECT_LT(max, 1e-4) << of;
            for (const JointId id : chain.hinges) {
              EXPECT_GT(std::abs(chain.world.joint_state(id).position[0]), 0.499) << of;
            }
          }
        }
      }
    }
  }
}

struct Hips {
  double damping = 0, armature = 0;
  bool spine = false, anchored = false;
};

// A trunk and two legs deep in it, each on two hinges at one place with a small body between them, which let neither
// part; and with a spine, a back that is deep in the legs too.
std::vector<BodyId> add_hips(World& world, const Hips& of) {
  const auto hinge = [&](BodyId first, BodyId second, const Vector3& at, const Vector3& axis) {
    HingeJoint made;
    made.angle.armature = of.armature;
    if (of.damping > 0) made.angle.spring = JointSpring{.damping = of.damping};
    world.add_joint(joint_at(world, made, first, second, at, axis));
    world.set_collision_enabled(first, second, false);
  };
  const BodyType type = of.anchored ? BodyType::Static : BodyType::Dynamic;
  std::vector<BodyId> ids;
  const BodyId trunk = world.add_body({.type = type, .shape = Box{{0.15, 0.1, 0.1}}, .mass = 10});
  for (const double side : {1.0, -1.0}) {
    const Vector3 at(0, 0.05 * side, -0.06);
    const BodyId hip = world.add_body(
        {.shape = Sphere{0.02}, .position = at, .mass = 1, .inertia = Matrix3(0.001 * Matrix3::Identity())});
    const BodyId leg = world.add_body({.shape = Box{{0.08, 0.08, 0.2}}, .position = {0, 0.07 * side, -0.2}, .mass = 5});
    hinge(trunk, hip, at, Vector3::UnitX());
    hinge(hip, leg, at, Vector3::UnitY());
    ids.insert(ids.end(), {hip, leg});
  }
  if (!of.anchored) ids.push_back(trunk);
  if (!of.spine) return ids;
  ids.push_back(world.add_body({.shape = Box{{0.1, 0.15, 0.1}}, .position = {0, 0, 0.08}, .mass = 5}));
  hinge(trunk, ids.back(), {0, 0, 0.02}, Vector3::UnitY());
  return ids;
}

// Springs aside: what is pushed apart may be pushed against them, and they give that back.
TEST(PartedJoints, WhatJointsHoldInOneAnotherStaysAtRest) {
  for (const bool spine : {false, true}) {
    for (const bool anchored : {false, true}) {
      for (const double damping : {0.0, 1.0}) {
        for (const double armature : {0.0, 0.01}) {
          World world({.gravity = Vector3::Zero()});
          const std::vector<BodyId> ids = add_hips(world, {damping, armature, spine, anchored});
          double max = 0;
          for (int i = 0; i < 180; ++i) {
            world.step(dt);
            max = std::max(max, kinetic_energy(world, ids));
          }
          EXPECT_TRUE(world.quarantined().empty());
          EXPECT_LT(max, 1e-3) << "J, with damping " << damping << ", armature " << armature << ", spine " << spine
                               << ", anchored " << anchored;
        }
      }
    }
  }
}

// A universal joint that starts where its axes are one, and a rotor in the joint after it: along a coordinate that
// moves nothing a rotor has no answer to how it bends, and everything was lost in the first step.
TEST(PartedJoints, ARotorWhereAxesAreOneLosesNothing) {
  World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = JointSolver::Direct}});
  const BodyId first = world.add_body(box({1, 1, 1}, {0.5, 0.5, 0.2}));
  const BodyId second = world.add_body(box({1, 1, 1}, {0.5, 0.5, 0.2}));
  const BodyId third = world.add_body(box({0.57, -0.03, -0.85}, {0.3, 0.3, 0.2}));
  const Quaternion quarter(Eigen::AngleAxisd(std::acos(0.0), Vector3::UnitZ()));
  world.add_joint({.kind = UniversalJoint{.second = {.armature = 2, .friction = 50}},
                   .first = first,
                   .second = second,
                   .frame_first = {{0.5, 0.5, 0.5}, Quaternion(-0.123, -0.696, -0.696, -0.123)},
                   .frame_second = {{-0.09, -0.09, -0.09}, Quaternion::Identity()}});
  SixDofJoint joint;
  joint.offset[0].spring = JointSpring{.hertz = 13, .rest = 0.5};
  joint.turn[2].armature = 1.1;
  world.add_joint({.kind = joint,
                   .first = second,
                   .second = third,
                   .frame_first = {{-0.2, -0.5, -0.9}, quarter},
                   .frame_second = {{0.2, 0.5, 0.9}, quarter}});
  run(world, 10);
  EXPECT_TRUE(world.quarantined().empty());
}

}  // namespace
}  // namespace atl::test::parted_joints_test
