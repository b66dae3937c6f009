// A wheel's suspension carries the chassis: its frequency is that at which the chassis bounces on it.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <variant>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::wheel_suspension_test {
namespace {

constexpr double radius = 0.35;
constexpr double load = 1200;  // kg

struct Car {
  World world;
  BodyId chassis;
  JointId wheel;

  explicit Car(const WheelJoint& joint = {}) {
    world.add_body(ground());
    BodyDef body = box({0, 0, 2 * radius + 0.3}, {2, 0.8, 0.3});
    body.mass = load;
    chassis = world.add_body(body);
    for (const double x : {-1.3, 1.3}) {
      for (const double y : {-0.8, 0.8}) {
        BodyDef ball = sphere({x, y, radius}, radius);
        ball.mass = 20;
        wheel = world.add_joint(joint_at(world, joint, chassis, world.add_body(ball), ball.position));
      }
    }
  }
};

// kg, of the chassis at a wheel: 1 / (1 / m + y^2 / I_x + x^2 / I_y), with the moments of a box.
double mass_at_wheel() {
  const double about_x = load / 3 * (0.8 * 0.8 + 0.3 * 0.3), about_y = load / 3 * (2.0 * 2.0 + 0.3 * 0.3);
  return 1 / (1 / load + 0.8 * 0.8 / about_x + 1.3 * 1.3 / about_y);
}

TEST(WheelSuspension, CarriesACarByDefault) {
  Car car;
  for (int i = 0; i < 300; ++i) car.world.step(dt);
  const double omega = 2 * std::numbers::pi * WheelJoint{}.suspension.spring->hertz;
  const double sag = load / 4 * g / (mass_at_wheel() * omega * omega);
  EXPECT_NEAR(car.world.joint_state(car.wheel).position[0], sag, 1e-3 * sag);
  EXPECT_LT(sag, 0.1);
  EXPECT_LT(car.world.velocity(car.chassis).norm(), 1e-3);
}

TEST(WheelSuspension, CountsByTheChassisAsItIsWhenSet) {
  Car car({.suspension = {.spring = JointSpring{.hertz = 3, .damping_ratio = 0.5, .rest = -0.1}}});
  const auto spring = [&] { return *car.world.joint_axis(car.wheel, 0).spring; };
  const double omega = 6 * std::numbers::pi, mass = mass_at_wheel();
  EXPECT_NEAR(spring().stiffness.value(), mass * omega * omega, 1e-9 * mass * omega * omega);
  EXPECT_NEAR(spring().damping.value(), mass * omega, 1e-9 * mass * omega);
  EXPECT_EQ(spring().rest, -0.1);
  const double before = *spring().stiffness;
  car.world.set_mass(car.chassis, 2 * load);
  EXPECT_EQ(*spring().stiffness, before);  // loaded, it sinks
  car.world.set_joint_axis(car.wheel, {.spring = JointSpring{.hertz = 3}}, 0);
  EXPECT_NEAR(*spring().stiffness, 2 * before, 1e-9 * before);
}

TEST(WheelSuspension, RefusesWhatComesToNoStiffness) {
  Car car;
  expect_error([&] { car.world.set_joint_axis(car.wheel, {.spring = JointSpring{.hertz = 1e15}}, 0); },
               {"suspension.spring.stiffness"});
  JointDef other = car.world.joint(car.wheel);
  other.kind = WheelJoint{};
  other.first = {};
  expect_error([&] { car.world.set_joint(car.wheel, other); }, {"the bodies are"});
}

TEST(WheelSuspension, OnWhatIsNotDynamicAFrequencyStaysOne) {
  World world;
  const BodyId rig = world.add_body({.type = BodyType::Static, .position = {0, 0, 2}});
  const JointId wheel =
      world.add_joint(joint_at(world, WheelJoint{}, rig, world.add_body(sphere({0, 0, 0}, radius)), {}));
  EXPECT_EQ(std::get<WheelJoint>(world.joint(wheel).kind), WheelJoint{});
}

}  // namespace
}  // namespace atl::test::wheel_suspension_test
