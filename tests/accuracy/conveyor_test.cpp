// A surface velocity is what friction measures slip against: it accelerates what lies on it at mu g, and then carries
// it.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scene_run.h"

namespace atl::test::conveyor_test {
namespace {

constexpr double friction = 0.5;
constexpr double speed = 2;  // m/s

BodyDef belt(const Vector3& surface_velocity, const Vector3& half_extents = {20, 20, 0.5}) {
  BodyDef def = static_box({0, 0, -half_extents.z()}, half_extents);
  def.material.friction = friction;
  def.surface_velocity = surface_velocity;
  return def;
}

BodyDef crate(const Vector3& position = {0, 0, 0.25}) {
  BodyDef def = box(position, {0.5, 0.5, 0.25});
  def.material.friction = friction;
  return def;
}

TEST(Conveyor, AcceleratesABoxAtMuGAndThenCarriesIt) {
  for (const Stabilisation stabilisation :
       {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    World world({.settings = {.stabilisation = stabilisation}});
    world.add_body(belt({speed, 0, 0}));
    const BodyId box = world.add_body(crate());
    const double reached = speed / (friction * g);  // s
    for (int i = 1; i <= 120; ++i) {
      world.step(dt);
      const double time = i * dt, pushed = std::min(time, reached);
      const double travelled = friction * g * pushed * pushed / 2 + speed * (time - pushed);
      ASSERT_NEAR(world.pose(box).position.x(), travelled, 5e-3) << static_cast<int>(stabilisation) << " step " << i;
      ASSERT_NEAR(world.velocity(box).x(), friction * g * pushed, 2 * friction * g * substep()) << "step " << i;
    }
    EXPECT_NEAR(world.velocity(box).x(), speed, 1e-4);
    EXPECT_LT(std::abs(world.pose(box).position.y()), 1e-4);
    EXPECT_LT(world.angular_velocity(box).norm(), 1e-3);
  }
}

TEST(Conveyor, TakesABoxOnAtAnyHeadingAlike) {
  // From sideways at the same speed: slip is 45 degrees off either axis, and stays straight under a cone.
  World world;
  world.add_body(belt({speed, 0, 0}));
  BodyDef def = crate();
  def.velocity = {0, speed, 0};
  const BodyId box = world.add_body(def);
  const double stop = std::sqrt(2) * speed / (friction * g);
  const int steps = static_cast<int>(0.5 * stop / dt);
  run(world, steps);
  const double part = friction * g * steps * dt / std::sqrt(2);
  EXPECT_NEAR(world.velocity(box).x(), part, 2 * friction * g * substep());
  EXPECT_NEAR(world.velocity(box).y(), speed - part, 2 * friction * g * substep());
}

TEST(Conveyor, VelocityTurnsWithTheBody) {
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
    for (const double angle : {0.5, 1.5, -2.5}) {
      World world;
      BodyDef def = belt({speed, 0, 0});
      def.type = type;
      def.orientation = Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ()));
      world.add_body(def);
      const BodyId box = world.add_body(crate());
      run(world, 90);
      const Vector3 expected = speed * Vector3(std::cos(angle), std::sin(angle), 0);
      EXPECT_LT((world.velocity(box) - expected).norm(), 1e-3) << angle;
    }
  }
}

TEST(Conveyor, AddsToTheVelocityOfAKinematicBody) {
  World world;
  BodyDef def = belt({speed, 0, 0});
  def.type = BodyType::Kinematic;
  def.velocity = {0, 1, 0};
  world.add_body(def);
  const BodyId box = world.add_body(crate());
  run(world, 90);
  EXPECT_LT((world.velocity(box) - Vector3(speed, 1, 0)).norm(), 1e-3);
}

TEST(Conveyor, TurnsWithASpinningKinematicBody) {
  // A ball bearing's worth of friction would slip; this box is carried, so its velocity is the table's and the belt's.
  World world;
  BodyDef def = belt({0.2, 0, 0});
  def.type = BodyType::Kinematic;
  def.angular_velocity = {0, 0, 0.5};
  const BodyId table = world.add_body(def);
  const BodyId box = world.add_body(crate());
  run(world, 120);
  const Vector3 place = world.pose(box).position;
  const Vector3 along = world.pose(table).orientation * Vector3(0.2, 0, 0);
  const Vector3 expected = Vector3(0, 0, 0.5).cross(place) + along;
  EXPECT_LT((world.velocity(box) - expected).head<2>().norm(), 0.02 * expected.norm());
  // The belt's course in the table's frame is straight: the box has come 0.2 m/s from the middle, less the start.
  EXPECT_NEAR((world.pose(table).orientation.inverse() * place).x(), 0.2 * 2, 0.02);
}

TEST(Conveyor, WorksOnAHalfSpaceAndOnASlope) {
  const double angle = 0.3;  // tan a = 0.31 < 0.5: friction carries it uphill
  World world({.gravity = g * Vector3(std::sin(angle), 0, -std::cos(angle))});
  BodyDef plane = ground(friction);
  plane.surface_velocity = {-1, 0, 0};
  world.add_body(plane);
  const BodyId box = world.add_body(crate());
  const double acceleration = g * (friction * std::cos(angle) - std::sin(angle));
  run(world, 20);
  EXPECT_NEAR(world.velocity(box).x(), -acceleration * 20 * dt, 2 * friction * g * substep());
  run(world, 160);
  EXPECT_NEAR(world.velocity(box).x(), -1, 1e-3);
}

TEST(Conveyor, OnlyThePartInTheTangentPlaneCounts) {
  const auto end = [](const Vector3& surface_velocity) {
    World world;
    world.add_body(belt(surface_velocity));
    const BodyId box = world.add_body(crate());
    run(world, 60);
    return world.pose(box).position;
  };
  EXPECT_LT((end({speed, 0, 5}) - end({speed, 0, 0})).norm(), 1e-5);
  EXPECT_LT((end({0, 0, -5}) - Vector3(0, 0, 0.25)).norm(), 1e-3);
}

TEST(Conveyor, WithoutFrictionItMovesNothing) {
  World world;
  world.add_body(belt({speed, 0, 0}));
  BodyDef def = crate();
  def.material.friction = 0;
  const BodyId box = world.add_body(def);
  run(world, 60);
  EXPECT_LT(world.velocity(box).head<2>().norm(), 1e-6);
}

TEST(Conveyor, DynamicBodyDrivesItselfOverTheGround) {
  // A tracked vehicle: its surface runs backwards at 1 m/s, so it runs forwards until it doesn't slip.
  World world;
  world.add_body(ground(friction));
  BodyDef def = crate();
  def.surface_velocity = {-1, 0, 0};
  const BodyId tank = world.add_body(def);
  run(world, 6);
  EXPECT_NEAR(world.velocity(tank).x(), friction * g * 6 * dt, 2 * friction * g * substep());
  run(world, 60);
  EXPECT_NEAR(world.velocity(tank).x(), 1, 1e-3);
  EXPECT_LT(world.angular_velocity(tank).norm(), 0.1);
}

TEST(Conveyor, BetweenDynamicBodiesKeepsMomentum) {
  World world({.gravity = Vector3::Zero()});
  std::vector<BodyId> ids;
  for (const double side : {-1.0, 1.0}) {
    BodyDef def = crate({0, 0, side * 0.25});
    def.velocity = {0, 0, -side * 1};
    if (side > 0) def.surface_velocity = {-speed, 0, 0};
    ids.push_back(world.add_body(def));
  }
  run(world, 30);
  EXPECT_GT(world.velocity(ids[1]).x(), 0.1) << "it pushes itself off the other";
  EXPECT_LT(momentum(world, ids).norm(), 1e-4 * world.mass(ids[0]) * speed);
}

TEST(Conveyor, RollsABallThatStaysWhereItIs) {
  // A ball put on a belt keeps its angular momentum about the contact: it rolls at 2/7 of the belt's speed.
  World world;
  world.add_body(belt({speed, 0, 0}));
  BodyDef def = sphere({0, 0, 0.5});
  def.material.friction = friction;
  const BodyId ball = world.add_body(def);
  run(world, 120);
  EXPECT_NEAR(world.velocity(ball).x(), 2.0 / 7 * speed, 1e-3 * speed);
  EXPECT_NEAR(world.angular_velocity(ball).y(), -5.0 / 7 * speed / 0.5, 2e-3 * speed);
}

TEST(Conveyor, ForceIsThatOfSlidingFrictionUntilItCarriesAndThenNone) {
  World world;
  const BodyId ground = world.add_body(belt({speed, 0, 0}));
  const BodyId box = world.add_body(crate());
  run(world, 12);
  const double weight = world.mass(box) * g;
  const Vector3 pushed = contact_force(world, ground, box);
  EXPECT_NEAR(pushed.x(), friction * weight, 0.01 * weight);
  EXPECT_NEAR(pushed.z(), weight, 0.02 * weight);
  run(world, 60);
  EXPECT_LT(contact_force(world, ground, box).head<2>().norm(), 1e-3 * weight);
}

TEST(Conveyor, WhatItCarriesStaysAwakeAndWhatItPressesAgainstAStopFallsAsleep) {
  World world({.settings = {.sleeping = true}});
  world.add_body(belt({speed, 0, 0}));
  const BodyId carried = world.add_body(crate({0, 3, 0.25}));
  const BodyId stopped = world.add_body(crate());
  world.add_body(static_box({1, 0, 0.5}, {0.5, 1, 0.5}));
  run(world, 180);
  EXPECT_FALSE(world.is_asleep(carried));
  EXPECT_NEAR(world.velocity(carried).x(), speed, 1e-3);
  EXPECT_TRUE(world.is_asleep(stopped));
}

TEST(Conveyor, SceneCarriesItsBoxesOntoTheLastBelt) {
  SceneRun conveyor("conveyor:boxes=6");
  run_finite(conveyor.world, 1200);
  for (std::size_t i = 0; i < conveyor.ids.size(); ++i) {
    if (conveyor.world.type(conveyor.ids[i]) != BodyType::Dynamic) continue;
    const Vector3 place = conveyor.world.pose(conveyor.ids[i]).position;
    EXPECT_NEAR(place.z(), 1, 0.02) << i << " lies on the third belt";
    EXPECT_NEAR(place.y(), 6, 1) << i;
  }
  EXPECT_LT(conveyor.penetration().max, 1e-2);
}

TEST(Conveyor, ABeltSlowerThanWhatCountsAsRestCarriesOn) {
  const double slow = 0.02;
  World world({.settings = {.sleeping = true}});
  ASSERT_LT(slow, world.settings().sleep_speed);
  world.add_body(belt({slow, 0, 0}));
  const BodyId box = world.add_body(crate());
  run(world, 300);
  EXPECT_NEAR(world.pose(box).position.x(), slow * 300 * dt, 1e-3);
}

TEST(Conveyor, StartsAndStopsWhatSleepsOnIt) {
  World world({.settings = {.sleeping = true}});
  const BodyId ground = world.add_body(belt({0, 0, 0}));
  const BodyId box = world.add_body(crate());
  run(world, 120);
  ASSERT_TRUE(world.is_asleep(box));
  world.set_surface_velocity(ground, {speed, 0, 0});
  run(world, 120);
  EXPECT_NEAR(world.velocity(box).x(), speed, 1e-4);
  world.set_surface_velocity(ground, {0, 0, 0});
  run(world, 180);
  EXPECT_TRUE(world.is_asleep(box));
  EXPECT_THROW(world.set_surface_velocity(ground, {std::nan(""), 0, 0}), Error);
}

}  // namespace
}  // namespace atl::test::conveyor_test
