// Numbers that single precision can't hold are refused by name, before anything is computed with them.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <vector>

#include "support/expect_error.h"

namespace atl {
namespace {

struct Case {
  const char* field;
  std::function<void(World&, double)> give;
};

BodyDef ball(const std::function<void(BodyDef&)>& change) {
  BodyDef def{.shape = Sphere{0.5}};
  change(def);
  return def;
}

std::vector<Case> cases() {
  const auto body = [](auto member) {
    return [member](World& world, double value) { world.add_body(ball([&](BodyDef& def) { member(def, value); })); };
  };
  const auto shape = [](auto make) {
    return [make](World& world, double value) { world.add_body({.shape = make(value)}); };
  };
  const auto settings = [](auto member) {
    return [member](World& world, double value) {
      Settings changed;
      member(changed, value);
      world.set_settings(changed);
    };
  };
  const auto hinge = [](auto change) {
    return [change](World& world, double value) {
      const BodyId first = world.add_body({.shape = Sphere{0.5}});
      const BodyId second = world.add_body({.shape = Sphere{0.5}, .position = {2, 0, 0}});
      HingeJoint joint;
      change(joint.angle, value);
      world.add_joint({.kind = joint, .first = first, .second = second});
    };
  };
  return {
      {"Sphere.radius", shape([](double x) { return Sphere{x}; })},
      {"Box.half_extents", shape([](double x) {
         return Box{{1, x, 1}};
       })},
      {"Capsule.half_height", shape([](double x) {
         return Capsule{1, x};
       })},
      {"Cylinder.radius", shape([](double x) {
         return Cylinder{x, 1};
       })},
      {"Cone.half_height", shape([](double x) {
         return Cone{1, x};
       })},
      {"Ellipsoid.half_axes", shape([](double x) {
         return Ellipsoid{{1, x, 1}};
       })},
      {"BodyDef.density", body([](BodyDef& def, double x) { def.density = x * 1e15; })},
      {"BodyDef.mass", body([](BodyDef& def, double x) { def.mass = x * 1e15; })},
      {"BodyDef.material.friction", body([](BodyDef& def, double x) { def.material.friction = x; })},
      {"BodyDef.material.rolling_friction", body([](BodyDef& def, double x) { def.material.rolling_friction = x; })},
      {"BodyDef.material.torsional_friction",
       body([](BodyDef& def, double x) { def.material.torsional_friction = x; })},
      {"BodyDef.gravity_scale", body([](BodyDef& def, double x) { def.gravity_scale = -x; })},
      {"BodyDef.linear_damping", body([](BodyDef& def, double x) { def.linear_damping = x; })},
      {"BodyDef.angular_damping", body([](BodyDef& def, double x) { def.angular_damping = x; })},
      {"Settings.contact_hertz", settings([](Settings& s, double x) { s.contact_hertz = x; })},
      {"Settings.slop", settings([](Settings& s, double x) { s.slop = x; })},
      {"Settings.contact_push_speed", settings([](Settings& s, double x) { s.contact_push_speed = x; })},
      {"Settings.joint_damping_ratio", settings([](Settings& s, double x) { s.joint_damping_ratio = x; })},
      {"Settings.target.penetration", settings([](Settings& s, double x) { s.target.penetration = x; })},
      {"Settings.target.joint_gap", settings([](Settings& s, double x) { s.target.joint_gap = x; })},
      {"Settings.target.residual", settings([](Settings& s, double x) { s.target.residual = x; })},
      {"Settings.target.motion", settings([](Settings& s, double x) { s.target.motion = x; })},
      {"range.lower", hinge([](JointAxis& axis, double x) { axis.range.lower = -x; })},
      {"spring.hertz", hinge([](JointAxis& axis, double x) { axis.spring = JointSpring{.hertz = x}; })},
      {"spring.rest", hinge([](JointAxis& axis, double x) { axis.spring = JointSpring{.rest = x}; })},
      {"spring.stiffness", hinge([](JointAxis& axis, double x) { axis.spring = JointSpring{.stiffness = x * 1e15}; })},
      {"armature", hinge([](JointAxis& axis, double x) { axis.armature = x * 1e15; })},
      {"friction", hinge([](JointAxis& axis, double x) { axis.friction = x * 1e15; })},
      {"cast.translation",
       [](World& world, double x) {
         Queries(world).cast_shape({.shape = Sphere{1}, .translation = {x, 0, 0}});
       }},
      {"ray.origin",
       [](World& world, double x) {
         Queries(world).cast_ray({.origin = {x, 0, 0}});
       }},
  };
}

TEST(NumberBounds, WhatSinglePrecisionCantHoldIsRefusedByName) {
  for (const Case& one : cases()) {
    for (const double beyond : {1.01e15, 1e100, 1e200}) {
      World world;
      test::expect_error([&] { one.give(world, beyond); }, {one.field, "at most"});
    }
  }
}

TEST(NumberBounds, AMassIsRefusedForItsMomentsToo) {
  World world;
  const BodyId large = world.add_body({.shape = Box{{1e6, 1e6, 1e6}}, .mass = 1});
  const std::uint64_t before = world.state_hash();
  test::expect_error([&] { world.set_mass(large, 1e30); }, {"World::set_mass: mass is 1e+30", "moments of inertia"});
  EXPECT_EQ(world.state_hash(), before);
  EXPECT_EQ(world.mass(large), 1);
  world.set_mass(large, 1e20);
  EXPECT_EQ(world.mass(large), 1e20);
}

TEST(NumberBounds, WhatItHoldsStepsToFiniteNumbers) {
  for (const Case& one : cases()) {
    World world;
    const BodyId ground = world.add_body({.type = BodyType::Static, .shape = HalfSpace{.normal = {0, 0, 1}}});
    try {
      one.give(world, 1e14);
    } catch (const Error&) {
      continue;  // by what follows from it: its mass, say
    }
    for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
    EXPECT_TRUE(world.contains(ground));
    EXPECT_TRUE(world.positions().allFinite() && world.velocities().allFinite()) << one.field;
  }
}

TEST(NumberBounds, LargeQuaternionsAreScaledBeforeTheirNormIsTaken) {
  for (const double size : {1e-3, 1.0, 1e99, 1e120, 1e154, 1e160, 1e300, 1.7e308}) {
    World world;
    const BodyId id = world.add_body({.shape = Sphere{1}, .orientation = Quaternion(size, 0, size, 0)});
    const Quaternion found = world.pose(id).orientation;
    EXPECT_NEAR(found.w(), std::sqrt(0.5), 1e-15) << size;
    EXPECT_NEAR(found.y(), std::sqrt(0.5), 1e-15) << size;
  }
}

// The least moment of a needle that lies askew in its frame is lost in the rounding of the largest. It turns as one
// that lies straight all the same, as both have a millionth of the largest.
TEST(NumberBounds, MomentsThatRoundingSwallowsAreAMillionthOfTheLargest) {
  const Quaternion turn(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()));
  for (const double length : {10.0, 1e4}) {
    const Box box{{length, 1e-3, 1e-3}};
    World world({.gravity = Vector3::Zero()});
    const BodyId straight = world.add_body({.shape = box, .orientation = turn, .mass = 1});
    const BodyId askew =
        world.add_body({.shape = Compound{{{.shape = box, .orientation = turn}}}, .position = {0, 1e6, 0}, .mass = 1});
    const double moment = 1e-6 * (length * length + 1e-6) / 3;
    for (const BodyId id : {straight, askew}) world.apply_force(id, {0, 0, 0}, turn * Vector3(60 * moment, 0, 0));
    world.step(1.0 / 60);
    for (const BodyId id : {straight, askew}) {
      const Vector3 spin = turn.conjugate() * world.angular_velocity(id);
      EXPECT_NEAR(spin.x(), 1, 1e-3) << length;
      EXPECT_LT(spin.tail<2>().norm(), 1e-3) << length;
    }
  }
}

TEST(NumberBounds, ImpulsesThatWouldOverflowAreRefusedAndChangeNothing) {
  World world;
  const BodyId ball = world.add_body({.shape = Sphere{0.5}, .velocity = {1, 2, 3}});
  const BodyId light = world.add_body({.shape = Sphere{0.5}, .position = {3, 0, 0}, .mass = 0.01});
  const std::uint64_t before = world.state_hash();
  for (const Vector3& point : {Vector3(1e300, 0, 0), Vector3(1e300, 1e300, 1e300)}) {
    test::expect_error(
        [&] {
          world.apply_impulse(ball, {1e300, -1e300, 0}, point);
        },
        {"World::apply_impulse: the angular velocity after it"});
  }
  test::expect_error(
      [&] {
        world.apply_impulse(light, {1e308, 0, 0}, world.centre_of_mass(light));
      },
      {"World::apply_impulse: the velocity after it"});
  EXPECT_EQ(world.state_hash(), before);
}

}  // namespace
}  // namespace atl
