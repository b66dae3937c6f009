// A surface that turns on its body: friction takes what lies on it along as a turning body would.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/bodies.h"

namespace atl::test::turntable_test {
namespace {

constexpr double turns = 1.5;  // rad/s
constexpr ContactSolver solvers[] = {ContactSolver::Iterative, ContactSolver::Direct};

BodyDef table(double friction = 0.8) {
  return {.type = BodyType::Static,
          .shape = Cylinder{.radius = 6, .half_height = 0.5},
          .position = {1, 2, -0.5},
          .material = {.friction = friction},
          .surface_angular_velocity = {0, 0, turns}};
}

Vector3 velocity_there(const Vector3& place) { return Vector3(0, 0, turns).cross(place - Vector3(1, 2, 0)); }

TEST(Turntable, TakesBoxesAlongAtItsAngularSpeed) {
  for (const ContactSolver solver : solvers) {
    for (const double radius : {0.0, 1.0, 2.0}) {
      World world({.settings = {.contact_solver = solver}});
      world.add_body(table());
      BodyDef def = box({1 + radius, 2, 0.25}, {0.5, 0.5, 0.25});
      def.velocity = velocity_there(def.position);
      const BodyId id = world.add_body(def);
      run(world, 120);
      EXPECT_NEAR(world.angular_velocity(id).z(), turns, 0.01 * turns) << radius;
      EXPECT_NEAR((world.pose(id).position - Vector3(1, 2, 0.25)).norm(), radius, 0.03) << "2 s later";
      EXPECT_LT((world.velocity(id) - velocity_there(world.pose(id).position)).norm(), 0.05) << radius;
    }
  }
}

// Friction is at most mu m g, and a circle at radius r takes m w^2 r.
TEST(Turntable, ThrowsOffWhatItsFrictionCannotHold) {
  const double friction = 0.3, farthest = friction * g / (turns * turns);
  for (const double part : {0.8, 1.2}) {
    World world;
    world.add_body(table(friction));
    BodyDef def = box({1 + part * farthest, 2, 0.25}, {0.25, 0.25, 0.25});
    def.velocity = velocity_there(def.position);
    def.angular_velocity = {0, 0, turns};
    def.material.friction = friction;
    const BodyId id = world.add_body(def);
    run(world, 90);
    const double radius = (world.pose(id).position - Vector3(1, 2, 0.25)).norm();
    if (part < 1) {
      EXPECT_NEAR(radius, part * farthest, 0.03);
    } else {
      EXPECT_GT(radius, 1.5 * farthest);
    }
  }
}

// Weltner, "Stable circular orbits of freely moving balls on rotating discs", Am. J. Phys. 47 (1979): a solid ball that
// rolls goes round in a circle at 2/7 of the disc's angular speed.
TEST(Turntable, ARollingBallGoesRoundAtTwoSeventhsOfItsSpeed) {
  for (const ContactSolver solver : solvers) {
    World world({.settings = {.contact_solver = solver}});
    world.add_body(table());
    BodyDef def = sphere({3, 2, 0.25}, 0.25);
    def.velocity = {0.5, 0, 0};
    const Vector3 rolls = velocity_there({3, 2, 0}) - def.velocity;  // = w x (0, 0, -r)
    def.angular_velocity = Vector3(rolls.y(), -rolls.x(), 0) / 0.25;
    const BodyId id = world.add_body(def);
    run(world, 120);
    const double angle = 2.0 / 7 * turns * 2;
    EXPECT_LT((world.velocity(id) - 0.5 * Vector3(std::cos(angle), std::sin(angle), 0)).norm(), 0.01);
  }
}

// Friction of m w^2 r holds it on its circle. Contacts that didn't turn with the disc let it out by 3.6% in this time,
// by 18% with one substep, and friction was told to point outwards.
TEST(Turntable, KeepsWhatRidesOnATurningBodyWhereItIs) {
  for (const ContactSolver solver : {ContactSolver::Auto, ContactSolver::Direct}) {
    for (const int substeps : {1, 4}) {
      for (const Shape& shape : {Shape(Box{Vector3::Constant(0.1)}), Shape(Cylinder{0.1, 0.1})}) {
        World world({.settings = {.substeps = substeps, .contact_solver = solver}});
        world.add_body({.type = BodyType::Kinematic,
                        .shape = Box{{3, 3, 0.5}},
                        .position = {0, 0, -0.5},
                        .angular_velocity = {0, 0, 1},
                        .material = {.friction = 0.8}});
        const BodyId rider = world.add_body({.shape = shape,
                                             .position = {1, 0, 0.1},
                                             .velocity = {0, 1, 0},
                                             .angular_velocity = {0, 0, 1},
                                             .material = {.friction = 0.8}});
        run(world, 1200);
        const Vector3 place = world.pose(rider).position;
        EXPECT_NEAR(place.head<2>().norm(), 1, 1e-3) << substeps;
        EXPECT_NEAR(std::remainder(std::atan2(place.y(), place.x()) - 20, 2 * std::numbers::pi), 0, 1e-3) << substeps;
        Vector3 held = Vector3::Zero();
        for (const ContactForce& force : world.contact_forces()) held += (force.b == rider ? 1 : -1) * force.friction;
        const Vector3 inwards = -world.mass(rider) * Vector3(place.x(), place.y(), 0);
        EXPECT_LT((held - inwards).norm(), 0.03 * inwards.norm()) << substeps;
      }
    }
  }
}

// A ball that sticks as it bounces leaves with 2/7 of the surface's speed; what it spins about the normal, torsional
// friction gives it.
TEST(Turntable, PassesItsMotionOnInABounce) {
  World world;
  BodyDef def = table();
  def.material = {.friction = 1, .restitution = 1, .torsional_friction = 0.5};
  world.add_body(def);
  BodyDef ball = sphere({2, 2, 0.6}, 0.25);
  ball.material = def.material;
  ball.velocity = {0, 0, -8};
  ball.gravity_scale = 0;
  const BodyId id = world.add_body(ball);
  run(world, 6);
  EXPECT_NEAR(world.velocity(id).y(), 2.0 / 7 * turns, 0.01);
  EXPECT_NEAR(world.angular_velocity(id).z(), turns, 0.01);
}

// A body's own surface turns about the body's origin, whatever its centre of mass, and pushes back what it drives.
TEST(Turntable, OnADynamicBodyKeepsMomentum) {
  for (const ContactSolver solver : solvers) {
    World world({.gravity = Vector3::Zero(), .settings = {.contact_solver = solver}});
    BodyDef lower = box({0, 0, -0.25}, {0.5, 0.5, 0.25}), upper = box({0.2, 0, 0.25}, {0.3, 0.3, 0.25});
    lower.velocity = {0, 0, 1};
    upper.velocity = {0, 0, -1};
    lower.mass = upper.mass = 1;
    lower.surface_angular_velocity = {0, 0, 4};
    const BodyId ids[] = {world.add_body(lower), world.add_body(upper)};
    run(world, 30);
    EXPECT_GT(world.angular_velocity(ids[1]).z(), 0.1);
    EXPECT_LT(momentum(world, {ids[0], ids[1]}).norm(), 1e-5);
    double spin = 0;
    for (const BodyId id : ids) {
      const Matrix3 axes = world.pose(id).orientation.toRotationMatrix();
      spin += (axes * *world.definition(id).inertia * axes.transpose() * world.angular_velocity(id)).z() +
              world.pose(id).position.cross(world.velocity(id)).z();
    }
    EXPECT_NEAR(spin, 0, 0.01 * world.angular_velocity(ids[1]).z());
  }
}

TEST(Turntable, ABodyOffItsCentreOfMassIsTurnedAboutItsOrigin) {
  World world({.settings = {.contact_solver = ContactSolver::Direct}});
  world.add_body(ground(0.8));
  BodyDef def = box({0, 0, 0.25}, {0.5, 0.5, 0.25});
  def.mass = 10;
  def.inertia = Matrix3::Identity();
  def.centre_of_mass = Vector3(0.3, 0, -0.1);
  def.surface_angular_velocity = {0, 0, -1};
  const BodyId id = world.add_body(def);
  run(world, 240);
  EXPECT_NEAR(world.angular_velocity(id).z(), 1, 0.02) << "until nothing slips";
  const Vector3 arm = world.pose(id).orientation * Vector3(-0.3, 0, 0.1);
  const Vector3 of_origin = world.velocity(id) + world.angular_velocity(id).cross(arm);
  EXPECT_LT(of_origin.norm(), 0.05) << "0.3 m/s if it were turned about its centre of mass";
}

TEST(Turntable, WhatTurnsOnItStaysAwake) {
  World world({.settings = {.sleeping = true}});
  BodyDef def = table();
  def.surface_angular_velocity = {0, 0, 0.02};
  world.add_body(def);
  const BodyId id = world.add_body(box({1, 2, 0.25}, {0.5, 0.5, 0.25}));
  run(world, 300);
  EXPECT_FALSE(world.is_asleep(id));
  EXPECT_NEAR(2 * world.pose(id).orientation.z(), 0.02 * 300 * dt, 2e-3);
}

}  // namespace
}  // namespace atl::test::turntable_test
