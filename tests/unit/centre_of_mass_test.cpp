// Bodies whose centre of mass is not the origin of their frame: cones, hulls, compounds.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

// A heavy ball and a light one, 2 m apart along x.
Compound dumbbell() {
  return {{{.shape = Sphere{0.2}, .position = {-1, 0, 0}, .density_factor = 3},
           {.shape = Sphere{0.2}, .position = {1, 0, 0}}}};
}

TEST(CentreOfMass, LiesWhereTheShapePutsIt) {
  World world({.gravity = Vector3::Zero()});
  const Quaternion turned(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitY()));
  const BodyId cone = world.add_body({.shape = Cone{0.5, 1}, .position = {1, 2, 3}, .orientation = turned});
  // A quarter of the height above the base, which the turn takes from -z to -x.
  EXPECT_LT((world.centre_of_mass(cone) - Vector3(0.5, 2, 3)).norm(), 1e-12);
  EXPECT_LT((world.pose(cone).position - Vector3(1, 2, 3)).norm(), 1e-12);

  const BodyId bell = world.add_body({.shape = dumbbell(), .position = {0, 5, 0}});
  EXPECT_LT((world.centre_of_mass(bell) - Vector3(-0.5, 5, 0)).norm(), 1e-12);
}

TEST(CentreOfMass, PosesAreThoseOfTheFrame) {
  World world({.gravity = Vector3::Zero()});
  const BodyId bell = world.add_body({.shape = dumbbell()});
  const Pose pose{{3, -1, 2}, Quaternion(Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()))};
  world.set_pose(bell, pose);
  EXPECT_LT((world.pose(bell).position - pose.position).norm(), 1e-12);
  EXPECT_LT((world.centre_of_mass(bell) - (pose.position + pose.orientation * Vector3(-0.5, 0, 0))).norm(), 1e-12);
}

TEST(CentreOfMass, IsWhatAFreeBodyTurnsAbout) {
  World world({.gravity = Vector3::Zero()});
  BodyDef def{.shape = dumbbell()};
  def.angular_velocity = {0, 0, 3};
  def.velocity = {0.5, 0, 0};
  const BodyId bell = world.add_body(def);
  const Vector3 start = world.centre_of_mass(bell);
  run(world, 60);
  EXPECT_LT((world.centre_of_mass(bell) - (start + Vector3(0.5, 0, 0))).norm(), 1e-9);
  const Vector3 arm(-0.5 * std::cos(3.0), -0.5 * std::sin(3.0), 0);
  EXPECT_LT((world.pose(bell).position - (world.centre_of_mass(bell) - arm)).norm(), 1e-6);
}

// The heavy end goes down: a dumbbell on a ridge under its frame's origin tips over it.
TEST(CentreOfMass, DecidesWhichWayABodyTips) {
  World world;
  world.add_body(static_box({0, 0, -0.1}, {0.05, 1, 0.1}));
  Compound rod = dumbbell();
  rod.children.push_back({.shape = Box{{1, 0.05, 0.05}}});
  const BodyId body = world.add_body({.shape = rod, .position = {0, 0, 0.06}});
  run(world, 30);
  const Vector3 axis = world.pose(body).orientation * Vector3::UnitX();
  EXPECT_GT(axis.z(), 0.1);
}

TEST(CentreOfMass, AsTheShapeHasItChangesNoBit) {
  const auto hash_of = [](bool given) {
    World world;
    world.add_body(static_box({0, 0, -0.1}, {3, 3, 0.1}));
    const MassProperties mass = mass_properties(Cone{0.5, 1});
    BodyDef def{.shape = Cone{0.5, 1}, .position = {0, 0, 2}, .mass = mass.mass, .inertia = mass.inertia};
    if (given) def.centre_of_mass = mass.centre;
    world.add_body(def);
    run(world, 100);
    return world.state_hash();
  };
  EXPECT_EQ(hash_of(true), hash_of(false));
}

TEST(CentreOfMass, IsInTheDefinitionAndInSnapshots) {
  World world;
  const BodyId body = world.add_body(
      {.shape = Sphere{0.5}, .mass = 2.0, .inertia = Matrix3::Identity(), .centre_of_mass = Vector3(0.1, 0.2, -0.3)});
  EXPECT_EQ(*world.definition(body).centre_of_mass, Vector3(0.1, 0.2, -0.3));
  Snapshot start;
  world.save(start);
  run(world, 10);
  World other;
  other.restore(start);
  EXPECT_EQ(*other.definition(body).centre_of_mass, Vector3(0.1, 0.2, -0.3));
  run(other, 10);
  EXPECT_EQ(other.state_hash(), world.state_hash());
}

TEST(CentreOfMass, TellsWhatIsWrongWithIt) {
  World world;
  expect_error([&] { world.add_body({.centre_of_mass = Vector3::Zero()}); }, {"centre_of_mass", "inertia"});
  BodyDef def{.mass = 1.0, .inertia = Matrix3::Identity(), .centre_of_mass = Vector3(0, std::nan(""), 0)};
  expect_error([&] { world.add_body(def); }, {"BodyDef.centre_of_mass", "nan"});
}

TEST(Compound, TellsWhatIsWrongWithAChild) {
  World world;
  Compound bad = dumbbell();
  bad.children[1].shape = Box{{1, -1, 1}};
  expect_error([&] { world.add_body({.shape = bad}); }, {"children[1]", "half_extents", "-1"});
  expect_error([&] { world.add_body({.shape = Compound{}}); }, {"children", "empty"});
}

TEST(Surfaces, CannotMoveFreely) {
  World world;
  const HeightField field(2, 2, 1, 1, {0, 0, 0, 0});
  expect_error([&] { world.add_body({.shape = field}); }, {"HeightField", "dynamic"});
  EXPECT_NO_THROW(world.add_body({.type = BodyType::Kinematic, .shape = field}));
}

}  // namespace
}  // namespace atl::test
