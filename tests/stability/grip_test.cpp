// A gripper with servos and rotors holds what it holds, however light or heavy that is.

#include <gtest/gtest.h>

#include "support/bodies.h"

namespace atl::test::grip_test {
namespace {

constexpr double half = 0.02;  // m, of the cube's edges

struct Gripper {
  World world;
  BodyId palm, cube;

  // Hangs on a wall by a servo; two fingers of 15 g press on the cube with 30 N each.
  explicit Gripper(double mass) {
    const BodyId wall = world.add_body(static_box({0, 0, 0.3}, Vector3::Constant(half)));
    palm = world.add_body({.shape = Box{{0.05, 0.1, 0.02}}, .position = {0, 0, 0.1}, .mass = 1.5});
    cube = world.add_body(
        {.shape = Box{Vector3::Constant(half)}, .position = {0, 0, 0.04}, .mass = mass, .material = {.friction = 1}});
    HingeJoint shoulder;
    shoulder.angle = {.motor = JointMotor{.max_force = 87, .servo = JointServo{.stiffness = 4500, .damping = 450}},
                      .armature = 0.1};
    join(shoulder, wall, palm, {0, 0, 0.3}, Vector3::UnitY());
    world.set_collision_enabled(palm, cube, false);
    for (const double side : {1.0, -1.0}) {
      const Vector3 at(0, side * (half + 0.004), 0.04);
      const BodyId finger = world.add_body(
          {.shape = Box{{0.01, 0.004, 0.01}}, .position = at, .mass = 0.015, .material = {.friction = 1}});
      SliderJoint slide;
      slide.offset = {
          .motor = JointMotor{.max_force = 100, .servo = JointServo{.target = 0.03, .stiffness = 1000, .damping = 20}},
          .armature = 0.1};
      join(slide, palm, finger, at, {0, -side, 0});
    }
  }
  void join(const JointKind& kind, BodyId first, BodyId second, const Vector3& at, const Vector3& axis) {
    world.add_joint(joint_at(world, kind, first, second, at, axis));
    world.set_collision_enabled(first, second, false);
  }
  Vector3 place() const { return world.pose(cube).position - world.pose(palm).position; }
};

// A grip gives by the compliance of friction alone: 1e-6 g dt a substep, times the share of the load.
TEST(Grip, HoldsACubeInPlace) {
  for (const double mass : {0.02, 0.05, 0.1, 0.5, 2.0}) {
    for (const double step : {1.0 / 60, 1.0 / 240}) {
      Gripper gripper(mass);
      run(gripper.world, static_cast<int>(0.5 / step), step);
      const Vector3 before = gripper.place();
      EXPECT_NEAR(before.z(), -0.06, 1e-5) << mass << " kg, 1/" << 1 / step;
      run(gripper.world, static_cast<int>(10 / step), step);
      EXPECT_LT((gripper.place() - before).norm(), 5e-5) << mass << " kg, 1/" << 1 / step;
    }
  }
}

}  // namespace
}  // namespace atl::test::grip_test
