// Every unusable definition is refused with the field and the value, and changes nothing.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string_view>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Bad {
  BodyDef def;
  std::string_view field;
  std::string_view value;  ///< as the message must show it
};

void expect_refused(const std::vector<Bad>& bad) {
  World world;
  world.add_body(ground());
  const std::uint64_t hash = world.state_hash();
  for (const Bad& b : bad) {
    expect_error([&] { world.add_body(b.def); }, {b.field, b.value});
    EXPECT_EQ(world.body_count(), 1u) << b.field;
    EXPECT_EQ(world.state_hash(), hash) << b.field;
  }
}

TEST(BodyDef, ShapesNeedPositiveFiniteSizes) {
  expect_refused({
      {{.shape = Sphere{0}}, "radius", "0"},
      {{.shape = Sphere{-1.5}}, "radius", "-1.5"},
      {{.shape = Sphere{nan}}, "radius", "nan"},
      {{.shape = Sphere{infinity}}, "radius", "inf"},
      {{.shape = Box{{0.5, 0, 0.5}}}, "half_extents", "0"},
      {{.shape = Box{{0.5, 0.5, -2.5}}}, "half_extents", "-2.5"},
      {{.shape = Box{{nan, 0.5, 0.5}}}, "half_extents", "nan"},
      {{.shape = Box{{0.5, infinity, 0.5}}}, "half_extents", "inf"},
  });
}

TEST(BodyDef, HalfSpacesNeedANormalAndDoNotMoveFreely) {
  const auto plane = [](const HalfSpace& shape) { return BodyDef{.type = BodyType::Static, .shape = shape}; };
  expect_refused({
      {plane({.normal = {0, 0, 0}}), "normal", "0"},
      {plane({.normal = {0, nan, 1}}), "normal", "nan"},
      {plane({.offset = infinity}), "offset", "inf"},
      {{.type = BodyType::Dynamic, .shape = HalfSpace{}}, "type", "ynamic"},
  });
}

TEST(BodyDef, StateMustBeFinite) {
  expect_refused({
      {{.position = {0, nan, 0}}, "position", "nan"},
      {{.position = {infinity, 0, 0}}, "position", "inf"},
      {{.orientation = Quaternion(0, 0, 0, 0)}, "orientation", "0"},
      {{.orientation = Quaternion(1, nan, 0, 0)}, "orientation", "nan"},
      {{.velocity = {0, 0, -infinity}}, "velocity", "inf"},
      {{.angular_velocity = {nan, 0, 0}}, "angular_velocity", "nan"},
      {{.surface_velocity = {0, nan, 0}}, "surface_velocity", "nan"},
      {{.material = {.friction_across = -1}}, "friction_across", "-1"},
      {{.material = {.friction_direction = {nan, 0, 0}}}, "friction_direction", "nan"},
      {{.surface_angular_velocity = {0, nan, 0}}, "surface_angular_velocity", "nan"},
      {{.type = BodyType::Static, .surface_velocity = {infinity, 0, 0}}, "surface_velocity", "inf"},
      {{.gravity_scale = nan}, "gravity_scale", "nan"},
  });
}

TEST(BodyDef, StaticBodiesHaveNoVelocity) {
  expect_refused({
      {{.type = BodyType::Static, .velocity = {1.5, 0, 0}}, "velocity", "1.5"},
      {{.type = BodyType::Static, .angular_velocity = {0, 0, 1.5}}, "angular_velocity", "1.5"},
  });
}

TEST(BodyDef, MassIsPositiveAndComesFromOnePlace) {
  expect_refused({
      {{.density = 0}, "density", "0"},
      {{.density = -1.5}, "density", "-1.5"},
      {{.density = infinity}, "density", "inf"},
      {{.mass = 0.0}, "mass", "0"},
      {{.mass = -1.5}, "mass", "-1.5"},
      {{.mass = nan}, "mass", "nan"},
      {{.mass = infinity}, "mass", "inf"},
      {{.inertia = Matrix3::Identity()}, "inertia", "mass"},
  });
}

TEST(BodyDef, InertiaMustBelongToSomeRigidBody) {
  Matrix3 skewed = Matrix3::Identity();
  skewed(0, 1) = 0.25;
  const Matrix3 indefinite = Vector3(1.5, 1, -0.25).asDiagonal();
  const Matrix3 too_flat = Vector3(1.5, 1, 3.25).asDiagonal();  // a plate has 1.5 + 1 = 2.5
  const Matrix3 not_finite = Vector3(1, nan, 1).asDiagonal();
  expect_refused({
      {{.mass = 1.0, .inertia = skewed}, "inertia", "0.25"},
      {{.mass = 1.0, .inertia = indefinite}, "inertia", "-0.25"},
      {{.mass = 1.0, .inertia = too_flat}, "inertia", "3.25"},
      {{.mass = 1.0, .inertia = not_finite}, "inertia", "nan"},
  });
}

TEST(BodyDef, MaterialAndDampingHaveTheirRanges) {
  expect_refused({
      {{.material = {.friction = -1.5}}, "friction", "-1.5"},
      {{.material = {.friction = nan}}, "friction", "nan"},
      {{.material = {.restitution = -0.25}}, "restitution", "-0.25"},
      {{.material = {.restitution = 1.25}}, "restitution", "1.25"},
      {{.material = {.rolling_friction = -1.5}}, "rolling_friction", "-1.5"},
      {{.material = {.rolling_friction = infinity}}, "rolling_friction", "inf"},
      {{.material = {.torsional_friction = -1.5}}, "torsional_friction", "-1.5"},
      {{.material = {.torsional_friction = nan}}, "torsional_friction", "nan"},
      {{.linear_damping = -1.5}, "linear_damping", "-1.5"},
      {{.linear_damping = infinity}, "linear_damping", "inf"},
      {{.angular_damping = -1.5}, "angular_damping", "-1.5"},
      {{.angular_damping = nan}, "angular_damping", "nan"},
  });
}

TEST(BodyDef, OrientationIsNormalisedOnUse) {
  World world;
  const BodyId id = world.add_body({.orientation = Quaternion(2, 0, 0, 2)});
  const Quaternion orientation = world.pose(id).orientation;
  EXPECT_NEAR(orientation.norm(), 1, 1e-15);
  EXPECT_LT(orientation.angularDistance(Quaternion(std::sqrt(0.5), 0, 0, std::sqrt(0.5))), 1e-7);
}

TEST(BodyDef, MassFollowsFromShapeAndDensityUnlessGiven) {
  World world;
  const double pi = std::numbers::pi;
  EXPECT_NEAR(world.mass(world.add_body({.shape = Sphere{2}, .density = 3})), 4.0 / 3 * pi * 8 * 3, 1e-4);
  EXPECT_NEAR(world.mass(world.add_body({.shape = Box{{1, 2, 3}}, .density = 5})), 8 * 6 * 5, 1e-4);
  EXPECT_NEAR(world.mass(world.add_body({.shape = Box{{1, 2, 3}}, .mass = 7.0})), 7, 1e-6);
  EXPECT_EQ(world.mass(world.add_body(static_box({0, 0, 0}, {1, 1, 1}))), infinity);
  EXPECT_EQ(world.mass(world.add_body({.type = BodyType::Kinematic})), infinity);
}

}  // namespace
}  // namespace atl::test
