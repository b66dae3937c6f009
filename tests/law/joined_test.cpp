// Contacts and joints of an island in one system: what neither sweeps nor taking turns hold.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/joined_run.h"
#include "support/min_turn.h"

namespace atl::test {
namespace {

Settings direct() { return {.contact_solver = ContactSolver::Direct, .joint_solver = JointSolver::Direct}; }

// Two jaws on sliders that motors press against a box between them, twenty times as heavy as one: friction carries it.
TEST(Joined, AGripperHoldsAHeavyBox) {
  constexpr double press = 1000, mass = 40, friction = 0.8;
  World world;
  const BodyId frame = world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 0.1, 0.1}}, .position = {0, 0, 3}});
  BodyDef load = box({0, 0, 1}, {0.2, 0.2, 0.2});
  load.mass = mass;
  load.material.friction = friction;
  const BodyId id = world.add_body(load);
  std::vector<BodyId> jaws;
  std::vector<JointId> sliders;
  for (const double side : {-1.0, 1.0}) {
    BodyDef jaw = box({side * 0.25, 0, 1}, {0.05, 0.2, 0.2});
    jaw.mass = mass / 20;
    jaw.material.friction = friction;
    jaws.push_back(world.add_body(jaw));
    const JointMotor motor{.speed = -side, .max_force = press};
    sliders.push_back(world.add_joint({.kind = SliderJoint{.offset = {.motor = motor}},
                                       .first = frame,
                                       .second = jaws.back(),
                                       .frame_first = {{side * 0.25, 0, -2}, Quaternion::Identity()}}));
  }
  std::int64_t at_once = 0;
  for (int i = 0; i < 300; ++i) at_once += world.step(dt).counts.direct_islands;
  EXPECT_GT(at_once, 290);
  EXPECT_NEAR(world.pose(id).position.z(), 1, 1e-3);
  EXPECT_LT(world.velocity(id).norm(), 1e-3);
  for (std::size_t i = 0; i < jaws.size(); ++i) {
    const Vector3 force = contact_force(world, jaws[i], id);
    EXPECT_NEAR(force.x(), i == 0 ? press : -press, 0.01 * press);
    EXPECT_NEAR(force.z(), mass * g / 2, 0.01 * mass * g);
    EXPECT_NEAR(world.pose(jaws[i]).position.z(), 1, 1e-9);
    // A slider carries its jaw and half of the box.
    EXPECT_NEAR(world.joint_state(sliders[i]).force.z(), (mass / 2 + mass / 20) * g, 0.01 * mass * g);
  }
}

// Solved by sweeps until the solver may choose: what it then does follows from the state, so it does the same restored.
TEST(Joined, TheChoiceIsThatOfARestoredWorld) {
  World world({.settings = {.contact_solver = ContactSolver::Iterative}});
  const BodyId frame =
      world.add_body({.type = BodyType::Static, .shape = Box{{0.1, 0.1, 0.1}}, .position = {-1, 0, 1}});
  BodyDef plank = box({0, 0, 1}, {0.5, 0.5, 0.05});
  plank.mass = 10;
  const BodyId carries = world.add_body(plank);
  world.add_joint(
      {.kind = FixedJoint{}, .first = frame, .second = carries, .frame_first = {{1, 0, 0}, Quaternion::Identity()}});
  BodyDef heavy = box({0, 0, 1.3}, Vector3::Constant(0.25));
  heavy.mass = 200;
  world.add_body(heavy);
  run(world, 120);
  Settings settings = world.settings();
  settings.contact_solver = ContactSolver::Auto;
  world.set_settings(settings);
  Snapshot saved;
  world.save(saved);
  EXPECT_EQ(world.step(dt).counts.direct_islands, 1);
  const std::uint64_t continued = world.state_hash();
  world.restore(saved);
  EXPECT_EQ(world.step(dt).counts.direct_islands, 1);
  EXPECT_EQ(world.state_hash(), continued);
}

// A chain of balls over a smooth drum, with as many on each side: it hangs there, and nothing opens.
TEST(Joined, AChainIsDrapedOverADrum) {
  constexpr int links = 41;
  constexpr double radius = 0.1, pitch = 0.25, drum = 1;
  World world({.settings = direct()});
  world.add_body({.type = BodyType::Static, .shape = Sphere{drum}, .position = {0, 0, 0}, .material = {.friction = 0}});
  std::vector<BodyId> ids;
  const double reach = drum + radius;
  for (int i = 0; i < links; ++i) {
    // On the drum, then straight down.
    const double along = pitch * (i - (links - 1) / 2);
    const double quarter = 0.5 * 3.14159265358979 * reach;
    const double angle = std::min(std::abs(along), quarter) / reach;
    const double side = along < 0 ? -1 : 1;
    BodyDef ball = sphere(
        {side * reach * std::sin(angle), 0, reach * std::cos(angle) - (std::abs(along) - angle * reach)}, radius);
    ball.material.friction = 0;
    ball.angular_damping = 1;
    ids.push_back(world.add_body(ball));
    if (i == 0) continue;
    const Vector3 to = world.pose(ids[i]).position - world.pose(ids[i - 1]).position;
    world.add_joint({.kind = BallJoint{},
                     .first = ids[i - 1],
                     .second = ids[i],
                     .frame_first = {to / 2, Quaternion::Identity()},
                     .frame_second = {-to / 2, Quaternion::Identity()}});
  }
  double gap = 0;
  for (int i = 0; i < 60; ++i) world.step(dt);
  for (std::size_t i = 1; i < ids.size(); ++i) {
    const Vector3 to = world.pose(ids[i]).position - world.pose(ids[i - 1]).position;
    gap = std::max(gap, to.norm() - pitch);
  }
  EXPECT_LT(gap, 1e-3);
  EXPECT_GT(world.pose(ids[(links - 1) / 2]).position.norm(), drum + radius - 1e-4);
  EXPECT_NEAR(world.pose(ids.front()).position.z(), world.pose(ids.back()).position.z(), 1e-3);
}

// A ladder on a hinge that leans on a smooth wall: moments about the hinge tell the wall's force.
TEST(Joined, AHingedRodLeansOnAWall) {
  constexpr double half = 1, angle = 0.6;  // m, rad from upright
  World world({.settings = direct()});
  const Quaternion lean(Eigen::AngleAxisd(-angle, Vector3::UnitY()));
  const Vector3 up = lean * Vector3::UnitZ();  // to the wall on the left
  const BodyId foot = world.add_body({.type = BodyType::Static, .shape = Box{{0.01, 0.01, 0.01}}});
  BodyDef rod{.shape = Capsule{.radius = 0.05, .half_height = half}};
  rod.position = half * up;
  rod.orientation = lean;
  rod.mass = 10;
  rod.material.friction = 0;
  const BodyId id = world.add_body(rod);
  const Vector3 tip = 2 * half * up;
  const BodyId wall = world.add_body(static_box({tip.x() - 0.05 - 0.5, 0, tip.z()}, {0.5, 1, 1}));
  const Quaternion about_y = min_turn(Vector3::UnitX(), Vector3::UnitY());
  const JointId hinge = world.add_joint({.kind = HingeJoint{},
                                         .first = foot,
                                         .second = id,
                                         .frame_first = {Vector3::Zero(), about_y},
                                         .frame_second = {Vector3(0, 0, -half), lean.conjugate() * about_y}});
  run(world, 120);
  const double expected = 10 * g * std::tan(angle) / 2;
  EXPECT_NEAR(contact_force(world, wall, id).x(), expected, 1e-3 * expected);
  EXPECT_NEAR(world.joint_state(hinge).force.x(), -expected, 1e-3 * expected);
  EXPECT_NEAR(world.joint_state(hinge).force.z(), 10 * g, 1e-3 * 10 * g);
}

// Two rods in a line, hinged to the world and to each other: the outer one is struck across its centre. 6/7 of the
// blow's energy is left once joints have had their part.
TEST(Joined, WhatIsStruckLosesEnergyToItsJoints) {
  World world({.gravity = {0, 0, 0}, .settings = {.joint_solver = JointSolver::Direct}});
  const BodyId wall = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}, .filter = {.mask = 0}});
  const Matrix3 inertia = Vector3(0.01, 1.0 / 12, 1.0 / 12).asDiagonal();
  BodyDef rod{.shape = Sphere{0.1}, .position = {0.5, 0, 0}, .mass = 1, .inertia = inertia, .filter = {.mask = 0}};
  const BodyId inner = world.add_body(rod);
  rod.position.x() = 1.5;
  const BodyId outer = world.add_body(rod);
  const Quaternion upright = min_turn(Vector3::UnitX(), Vector3::UnitZ());
  const auto hinge = [&](BodyId first, double first_x, BodyId second) {
    world.add_joint({.kind = HingeJoint{},
                     .first = first,
                     .second = second,
                     .frame_first = {{first_x, 0, 0}, upright},
                     .frame_second = {{-0.5, 0, 0}, upright}});
  };
  hinge(wall, 0, inner);
  hinge(inner, 0.5, outer);
  constexpr double speed = 0.5;
  world.set_velocity(outer, {0, speed, 0}, {0, 0, 0});
  for (int step = 0; step < 60; ++step) {
    world.step(dt);
    double energy = 0;
    for (const BodyId id : {inner, outer}) {
      energy += 0.5 * world.velocity(id).squaredNorm() + 0.5 / 12 * world.angular_velocity(id).squaredNorm();
    }
    EXPECT_NEAR(energy, 6.0 / 7 * 0.5 * speed * speed, 1e-4 * speed * speed) << step;
  }
}

// Two pairs of joined boxes meet where nothing else acts.
TEST(Joined, MomentumStays) {
  World world({.gravity = {0, 0, 0}, .settings = direct()});
  std::vector<BodyId> ids;
  for (const double side : {-1.0, 1.0}) {
    for (const double up : {0.0, 1.0}) {
      BodyDef def = box({side, 0.1 * side, 1.1 * up + 0.2 * side}, Vector3::Constant(0.4));
      def.velocity = {-2 * side, 0, 0.3 * up};
      def.angular_velocity = {0, 0.5 * up, 0.2};
      ids.push_back(world.add_body(def));
    }
    world.add_joint({.kind = BallJoint{},
                     .first = ids[ids.size() - 2],
                     .second = ids.back(),
                     .frame_first = {{0, 0, 0.55}, Quaternion::Identity()},
                     .frame_second = {{0, 0, -0.55}, Quaternion::Identity()}});
  }
  const Vector3 before = momentum(world, ids);
  std::int64_t at_once = 0;
  for (int i = 0; i < 60; ++i) at_once += world.step(dt).counts.direct_islands;
  EXPECT_GT(at_once, 5);
  double scale = 0;
  for (const BodyId id : ids) scale += world.mass(id) * 2;
  // Some steps are swept: by single precision, whose rounding is 6e-8.
  EXPECT_LT((momentum(world, ids) - before).norm(), 3e-7 * scale);
}

// Ragdolls in a heap: nothing opens, and nothing flies.
TEST(Joined, AHeapOfRagdollsHoldsTogether) {
  const Scene scene = load_scene("ragdolls:count=6");
  const auto fastest_with = [&](ContactSolver solver) {
    Scene how = scene;
    how.settings.contact_solver = solver;
    JoinedRun ragdolls(how, JointSolver::Direct);
    double fastest = 0;
    for (int i = 0; i < 150; ++i) {
      ragdolls.world.step(how.dt);
      for (const BodyId id : ragdolls.ids) fastest = std::max(fastest, ragdolls.world.velocity(id).norm());
    }
    EXPECT_LT(ragdolls.drift().max, 1e-9);
    return fastest;
  };
  EXPECT_LT(fastest_with(ContactSolver::Direct), 1.2 * fastest_with(ContactSolver::Iterative));
}

}  // namespace
}  // namespace atl::test
