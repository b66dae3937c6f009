// Friction that depends on its direction, as a skate's: along it little, across it much.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "support/bodies.h"
#include "support/motion.h"

namespace atl::test::directed_friction_test {
namespace {

constexpr ContactSolver solvers[] = {ContactSolver::Iterative, ContactSolver::Direct};
constexpr double along = 0.1, across = 0.8;

BodyDef sledge(const std::array<double, 3>& direction = {3, 0, 0}) {
  BodyDef def = box({0, 0, 0.1}, {0.5, 0.3, 0.1});
  def.material = {.friction = along, .friction_across = across, .friction_direction = direction};
  return def;
}

// The other surface takes no part.
BodyDef floor_of(CombineRule rule = CombineRule::Min) {
  BodyDef def = ground(1);
  def.material.friction_rule = rule;
  return def;
}

// Gravity of a plane that falls by `slope` rad towards `heading`, rad from x.
Vector3 tilted(double slope, double heading) {
  return g * Vector3(std::sin(slope) * std::cos(heading), std::sin(slope) * std::sin(heading), -std::cos(slope));
}

TEST(DirectedFriction, OnASlopeABoxSlidesAlongItAndHoldsAcrossIt) {
  for (const ContactSolver solver : solvers) {
    for (const bool of_floor : {false, true}) {
      for (const double heading : {0.0, std::numbers::pi / 2}) {
        World world({.gravity = tilted(0.3, heading), .settings = {.contact_solver = solver}});
        BodyDef floor = floor_of(), def = sledge();
        if (of_floor) std::swap(floor.material, def.material);  // a groove in the ground
        world.add_body(floor);
        const BodyId id = world.add_body(def);
        run(world, 60);
        const double expected = heading == 0 ? g * (std::sin(0.3) - along * std::cos(0.3)) : 0;
        EXPECT_NEAR(world.velocity(id).x(), expected, 0.02) << of_floor;
        EXPECT_NEAR(world.velocity(id).y(), 0, 1e-3) << of_floor;
      }
    }
  }
}

// The force f in the ellipse acts that takes the most power from the slip v: f = -N (a^2 v_x, b^2 v_y) /
// |(a v_x, b v_y)|. A body that starts from rest keeps the direction of its acceleration, which is that of v.
TEST(DirectedFriction, AcrossTheAxesItActsAsTakesTheMostPower) {
  const double slope = 0.5, pull = std::tan(slope) / std::sqrt(2);
  double low = 0, high = std::numbers::pi / 2;  // f = -N (a cos, b sin)
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.5 * (low + high), c = std::cos(angle), s = std::sin(angle);
    ((pull - along * c) * s / across < (pull - across * s) * c / along ? low : high) = angle;
  }
  const Vector3 expected =
      g * std::cos(slope) * Vector3(pull - along * std::cos(low), pull - across * std::sin(low), 0);
  for (const ContactSolver solver : solvers) {
    World world({.gravity = tilted(slope, std::numbers::pi / 4), .settings = {.contact_solver = solver}});
    world.add_body(floor_of());
    BodyDef def = sledge();
    def.locks.angular = {true, true, true};
    const BodyId id = world.add_body(def);
    run(world, 60);
    EXPECT_LT((world.velocity(id) - expected).norm(), 0.02 * expected.norm()) << world.velocity(id).transpose();
  }
}

TEST(DirectedFriction, ASkateKeepsItsSpeedAndGoesWhereItPoints) {
  constexpr double speed = 2, turns = 0.7;  // m/s, rad/s
  for (const ContactSolver solver : solvers) {
    World world({.settings = {.contact_solver = solver}});
    world.add_body(floor_of());
    BodyDef def = sphere({0, 0, 0.2}, 0.2);
    def.material = {.friction = 0, .friction_across = 1, .friction_direction = {1, 0, 0}};
    def.velocity = {speed, 0, 0};
    def.angular_velocity = {0, 0, turns};
    def.locks.angular = {true, true, false};
    const BodyId id = world.add_body(def);
    run(world, 120);
    const double angle = turns * 2, radius = speed / turns;
    EXPECT_NEAR(world.velocity(id).norm(), speed, 0.01 * speed);
    EXPECT_NEAR(std::atan2(world.velocity(id).y(), world.velocity(id).x()), angle, 0.02);
    const Vector3 place(radius * std::sin(angle), radius * (1 - std::cos(angle)), 0.2);
    EXPECT_LT((world.pose(id).position - place).norm(), 0.05);
  }
}

TEST(DirectedFriction, NeverMakesEnergy) {
  for (const ContactSolver solver : solvers) {
    for (const FrictionModel model : {FrictionModel::Cone, FrictionModel::Pyramid}) {
      for (const double ratio : {0.0, 0.02, 0.5}) {
        World world({.settings = {.friction = model, .contact_solver = solver}});
        world.add_body(floor_of());
        for (int i = 0; i < 6; ++i) {
          BodyDef def = sledge({std::cos(i), std::sin(i), 0.1 * i});
          def.material.friction = ratio * across;
          def.position += Vector3(0, 20 * i, 0);
          def.velocity = {3.0 - i, 1, 0};
          def.angular_velocity = {0, 0, 4.0 - 2 * i};
          world.add_body(def);
        }
        run(world, 2);
        double before = motion_of(world).kinetic;
        for (int step = 0; step < 120; ++step) {
          world.step(dt);
          const double now = motion_of(world).kinetic;
          ASSERT_LT(now, before + 1e-4 * before + 1e-6) << "step " << step << " ratio " << ratio;
          before = now;
        }
      }
    }
  }
}

// A ball that slides as it bounces is slowed by mu (1 + e) u, in each of the two directions with its own mu.
TEST(DirectedFriction, HoldsInABounce) {
  for (const bool crosswise : {false, true}) {
    World world({.gravity = Vector3::Zero()});
    world.add_body(floor_of());
    BodyDef def = sphere({0, 0, 0.5}, 0.3);
    def.material = {.friction = 0.05, .friction_across = 0.2, .friction_direction = {1, 0, 0}, .restitution = 0.5};
    def.velocity = crosswise ? Vector3(0, 6, -2) : Vector3(6, 0, -2);
    const BodyId id = world.add_body(def);
    run(world, 30);
    EXPECT_NEAR(world.velocity(id).z(), 1, 1e-3);
    EXPECT_NEAR(world.velocity(id)[crosswise ? 1 : 0], 6 - (crosswise ? 0.2 : 0.05) * 1.5 * 2, 5e-3);
  }
}

TEST(DirectedFriction, CombinesAlongEachAxis) {
  for (const bool by_pair : {false, true}) {
    for (const bool crosswise : {false, true}) {
      World world;
      BodyDef floor = ground(0.5), def = sledge();
      def.material.friction = 0.08;
      def.material.friction_across = 0.72;
      floor.material.id = def.material.id = 1;
      if (by_pair) world.set_material_pair({.first = 1, .second = 1, .friction = 0.3, .friction_across = 0.1});
      world.add_body(floor);
      def.velocity = crosswise ? Vector3(0, 6, 0) : Vector3(6, 0, 0);
      def.locks.angular = {true, true, true};
      const BodyId id = world.add_body(def);
      run(world, 30);
      const double expected = by_pair ? (crosswise ? 0.1 : 0.3) : (crosswise ? 0.6 : 0.2);
      EXPECT_NEAR(6 - world.velocity(id)[crosswise ? 1 : 0], expected * g * 30 * dt, 0.03);
    }
  }
}

// A box on its end is held as across in all directions: the shadow of a spindle on its end is round.
TEST(DirectedFriction, StoodOnItsEndIsAlikeInAllDirections) {
  for (const double heading : {0.0, 0.8}) {
    World world({.gravity = tilted(0.5, heading)});
    world.add_body(floor_of());
    const BodyId id = world.add_body(sledge({0, 0, 1}));
    run(world, 60);
    EXPECT_LT(world.velocity(id).norm(), 1e-3);
  }
}

TEST(DirectedFriction, AnswersTheContactProblem) {
  for (const ContactSolver solver : solvers) {
    World world({.gravity = tilted(0.5, 0.6),
                 .settings = {.iterations = 30, .contact_solver = solver, .keep_contact_problem = true}});
    world.add_body(floor_of());
    BodyDef def = sledge();
    def.locks.angular = {true, true, true};
    world.add_body(def);
    run(world, 30);
    const ContactProblem problem = world.contact_problem();
    ASSERT_EQ(problem.patches.size(), 1u);
    EXPECT_NEAR(problem.patches[0].friction, across, 1e-6);
    EXPECT_NEAR(problem.patches[0].friction_ratio, along / across, 1e-6);
    EXPECT_LT(measure_contact_residual(problem).relative, 1e-3);
  }
}

}  // namespace
}  // namespace atl::test::directed_friction_test
