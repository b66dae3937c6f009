// A kinematic platform moves as it is told, lifts what stands on it and carries it by friction.

#include <atoll/queries.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "support/scene_run.h"

namespace atl::test {
namespace {

constexpr double friction = 0.6;

struct Platform {
  World world;
  BodyId platform;
  BodyId rider;

  Platform() {
    platform =
        world.add_body({.type = BodyType::Kinematic, .shape = Box{{4, 4, 0.25}}, .material = {.friction = friction}});
    BodyDef def = box({0, 0, 0.75});
    def.material.friction = friction;
    rider = world.add_body(def);
    run(world, 60);
  }
  void move(const Vector3& velocity, const Vector3& spin = Vector3::Zero()) {
    world.set_velocity(platform, velocity, spin);
  }
  Vector3 rider_offset() const { return world.pose(rider).position - world.pose(platform).position; }
};

TEST(Kinematic, MovesAtItsVelocityWhateverStandsOnIt) {
  Platform lift;
  lift.move({0.5, -0.25, 1});
  run_finite(lift.world, 60);
  EXPECT_LT((lift.world.pose(lift.platform).position - Vector3(0.5, -0.25, 1)).norm(), 1e-6);
  EXPECT_EQ(lift.world.velocity(lift.platform), Vector3(0.5, -0.25, 1));
}

TEST(Kinematic, LiftsABox) {
  Platform lift;
  lift.move({0, 0, 0.5});
  run_finite(lift.world, 180);
  EXPECT_NEAR(lift.world.pose(lift.platform).position.z(), 1.5, 1e-6);
  EXPECT_NEAR(lift.rider_offset().z(), 0.75, 2e-3);
  EXPECT_NEAR(lift.world.velocity(lift.rider).z(), 0.5, 1e-3);
  EXPECT_LT(tilt(lift.world, lift.rider), 1e-3);
}

TEST(Kinematic, CarriesABoxByFriction) {
  // The box slips back by v^2 / (2 mu g) until it has the platform's speed, to within a substep's travel.
  Platform belt;
  const double speed = 2;
  belt.move({speed, 0, 0});
  run_finite(belt.world, 60);
  EXPECT_NEAR(belt.rider_offset().x(), -speed * speed / (2 * friction * g), 1.5 * speed * substep());
  EXPECT_NEAR(belt.world.velocity(belt.rider).x(), speed, 1e-3 * speed);
}

TEST(Kinematic, TurntableTurnsABoxOnItsAxis) {
  Platform table;
  const double rate = 0.5;
  table.move(Vector3::Zero(), {0, 0, rate});
  run_finite(table.world, 120);
  EXPECT_NEAR(table.world.angular_velocity(table.rider).z(), rate, 1e-2 * rate);
  EXPECT_LT(table.rider_offset().head<2>().norm(), 5e-3);
}

// It has no reach and no margin: any turn takes it elsewhere.
TEST(Kinematic, APlaneThatOnlyTurnsLiftsWhatIsInItsWay) {
  World world;
  const BodyId plane =
      world.add_body({.type = BodyType::Kinematic, .shape = HalfSpace{}, .angular_velocity = {1, 0, 0}});
  const BodyId ball = world.add_body(sphere({0, 5, 0.9}, 0.5));
  for (int i = 0; i < 36; ++i) {
    run_finite(world, 1);
    const Vector3 normal = world.pose(plane).orientation * Vector3::UnitZ();
    ASSERT_GT(normal.dot(world.pose(ball).position), 0.49) << i;
    const std::optional<RayHit> hit = Queries(world).cast_ray({.origin = {0, -5, 9}}, {.dynamic_bodies = false});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->distance, 9 + 5 * std::tan((i + 1) * dt), 1e-6) << i;
  }
  EXPECT_GT(world.velocity(ball).z(), 2);
}

TEST(Kinematic, BodiesIgnoreGravityForcesAndOneAnother) {
  World world;
  const BodyId a = world.add_body({.type = BodyType::Kinematic, .shape = Box{}, .velocity = {1, 0, 0}});
  const BodyId b = world.add_body({.type = BodyType::Kinematic, .shape = Box{}, .position = {1.5, 0, 0}});
  const BodyId wall = world.add_body(static_box({4, 0, 0}, {0.5, 1, 1}));
  world.apply_force(a, {0, 1e6, 0});
  run_finite(world, 240);
  EXPECT_LT((world.pose(a).position - Vector3(4, 0, 0)).norm(), 1e-6);
  EXPECT_EQ(world.pose(b).position, Vector3(1.5, 0, 0));
  EXPECT_EQ(world.pose(wall).position, Vector3(4, 0, 0));
}

}  // namespace
}  // namespace atl::test
