// Rolling: the lowest point of a round surface stays under its centre as the body turns, wherever the body's centre of
// mass is.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

const Quaternion on_its_side(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()));

World plane_world(ContactSolver contacts) {
  World world({.settings = {.contact_solver = contacts, .sleeping = false}});
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .material = {.friction = 1}});
  return world;
}

struct Roller {
  std::string name;
  Shape shape;
};

// Shapes that roll about the x axis with radius 0.5.
std::vector<Roller> rollers() {
  const auto wheel = [](double x) { return CompoundChild{Cylinder{0.5, 0.1}, {x, 0, 0}, on_its_side}; };
  return {{"two balls", Compound{{{Sphere{0.5}, {-1, 0, 0}}, {Sphere{0.5}, {1, 0, 0}}}}},
          {"capsule", Compound{{{Capsule{0.5, 1}, {0, 0, 0}, on_its_side}}}},
          {"cylinder", Compound{{{Cylinder{0.5, 1}, {0, 0, 0}, on_its_side}}}},
          {"wheels", Compound{{wheel(-1), wheel(1), {Box{{1, 0.05, 0.05}}}}}}};
}

// A compound of wheels that a turn put on its side once gained 23% of its speed in 2 s.
TEST(Rolling, IsSteadyWhateverTheShapesFrame) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double dt : {1.0 / 60, 1.0 / 240}) {
      for (const Roller& roller : rollers()) {
        World world = plane_world(contacts);
        const BodyId body = world.add_body({.shape = roller.shape,
                                            .position = {0, 0, 0.5},
                                            .velocity = {0, 2, 0},
                                            .angular_velocity = {-4, 0, 0},
                                            .material = {.friction = 1}});
        for (int step = 0; step < 5 / dt; ++step) world.step(dt);
        EXPECT_LT((world.velocity(body) - Vector3(0, 2, 0)).norm(), 2e-3) << roller.name << ", dt " << dt;
        EXPECT_LT((world.angular_velocity(body) - Vector3(-4, 0, 0)).norm(), 4e-3) << roller.name << ", dt " << dt;
        EXPECT_NEAR(world.pose(body).position.z(), 0.5, 2e-3) << roller.name << ", dt " << dt;
      }
    }
  }
}

// With its weight at depth d below its middle, what rolls is a pendulum of w^2 = m g d / (I + m (r - d)^2), which keeps
// its energy: the tenth swing is as large as the first, and as long.
void expect_steady_swings(const std::string& name, const Shape& shape, const Quaternion& frame, ContactSolver contacts,
                          double dt) {
  World world = plane_world(contacts);
  const double r = 0.5, m = 3, d = 0.1, inertia = 0.25, start = 0.1;
  const Quaternion tilt(Eigen::AngleAxisd(start, Vector3::UnitX()));
  const BodyId body = world.add_body({.shape = shape,
                                      .position = {0, 0, r},
                                      .orientation = tilt * frame,
                                      .mass = m,
                                      .inertia = Matrix3(inertia * Matrix3::Identity()),
                                      .centre_of_mass = Vector3(frame.conjugate() * Vector3(0, 0, -d)),
                                      .material = {.friction = 1}});
  const double w = std::sqrt(m * 9.81 * d / (inertia + m * (r - d) * (r - d)));
  const double swings = 10;
  for (int step = 0; step < std::lround(swings * 2 * std::numbers::pi / w / dt); ++step) world.step(dt);
  const Vector3 up = world.pose(body).orientation * frame.conjugate() * Vector3::UnitZ();
  const double lean = std::atan2(-up.y(), up.z()), rate = world.angular_velocity(body).x();
  const double max = std::hypot(lean, rate / w);
  EXPECT_NEAR(max / start, 1, 0.01) << name << ", dt " << dt;
  // The phase after 63 rad; the finite width of the swing accounts for some hundredths of the error.
  EXPECT_NEAR(std::atan2(rate / w, lean), 0, 0.1) << name << ", dt " << dt;
}

// A ball of which the weight is off its middle once swung 1.3 times as far with each swing.
TEST(Rolling, OfWhatIsLoadedKeepsItsEnergy) {
  for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
    for (const double dt : {1.0 / 60, 1.0 / 240}) {
      const Quaternion straight = Quaternion::Identity();
      expect_steady_swings("ball", Sphere{0.5}, straight, contacts, dt);
      expect_steady_swings("cylinder", Cylinder{0.5, 1}, on_its_side, contacts, dt);
      expect_steady_swings("capsule", Capsule{0.5, 1}, on_its_side, contacts, dt);
      expect_steady_swings("child", Compound{{{Cylinder{0.5, 1}, {0, 0, 0}, on_its_side}}}, straight, contacts, dt);
    }
  }
}

// Wheels whose cylinders are turned into their bodies' frames, as robots' are, in all ways to solve them.
TEST(Rolling, OfACartIsSteady) {
  const Quaternion across(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  for (const JointSolver joints : {JointSolver::Iterative, JointSolver::Direct}) {
    for (const ContactSolver contacts : {ContactSolver::Iterative, ContactSolver::Direct}) {
      World world({.settings = {.contact_solver = contacts, .joint_solver = joints, .sleeping = false}});
      world.add_body({.type = BodyType::Static, .shape = HalfSpace{}});
      const double r = 0.2, v = 2;
      const BodyId car = world.add_body(
          {.shape = Box{{0.6, 0.3, 0.1}}, .position = {0, 0, r + 0.05}, .velocity = {v, 0, 0}, .mass = 20.0});
      for (const double x : {-0.5, 0.5}) {
        for (const double y : {-0.4, 0.4}) {
          const BodyId wheel = world.add_body({.shape = Compound{{{Cylinder{r, 0.04}, {0, 0, 0}, across}}},
                                               .position = {x, y, r},
                                               .velocity = {v, 0, 0},
                                               .angular_velocity = {0, v / r, 0},
                                               .mass = 1.0});
          world.add_joint(joint_at(world, HingeJoint{}, car, wheel, Vector3(x, y, r), Vector3::UnitY()));
        }
      }
      for (int step = 0; step < 300; ++step) world.step(dt);
      EXPECT_LT((world.velocity(car) - Vector3(v, 0, 0)).norm(), 2e-3);
      EXPECT_NEAR(world.pose(car).position.z(), r + 0.05, 2e-3);
    }
  }
}

}  // namespace
}  // namespace atl::test
