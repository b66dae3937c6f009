// Each shape comes to rest on each kind of floor, and stays there: kinetic energy per kg below 1e-8 J after 5 s.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

struct Resting {
  std::string name;
  Shape shape;
  double height;  // of the body's origin when it rests
  Quaternion orientation = Quaternion::Identity();
};

// A hexagonal prism that narrows upwards.
std::vector<Vector3> hexagonal_corners(double radius, double half_height) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 6; ++i) {
    const double angle = std::numbers::pi / 3 * i;
    const Vector3 out(std::cos(angle), std::sin(angle), 0);
    corners.push_back(radius * out - half_height * Vector3::UnitZ());
    corners.push_back(0.7 * radius * out + half_height * Vector3::UnitZ());
  }
  return corners;
}

std::vector<Resting> resting_shapes() {
  const Quaternion lying(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  // A cone lies on its side when that is turned down by the angle of its slope.
  const double slope = std::atan2(0.5, 1.0);
  const Quaternion on_side(Eigen::AngleAxisd(std::numbers::pi / 2 + slope, Vector3::UnitX()));
  const double side_distance = 0.5 * std::sin(slope);  // from the middle of the axis to the side
  // The side of a tapered capsule leans by the angle at which the cone around its balls does.
  const double lean = std::asin(0.1);
  const Quaternion on_cone(Eigen::AngleAxisd(std::numbers::pi / 2 + lean, Vector3::UnitX()));
  const double tapered_height = 0.25;  // the middle between the balls' middles, at the mean of their radii
  return {
      {"Box", Box{}, 0.5},
      {"Sphere", Sphere{0.5}, 0.5},
      {"CapsuleLying", Capsule{0.3, 0.5}, 0.3, lying},
      {"CylinderStanding", Cylinder{0.4, 0.5}, 0.5},
      {"CylinderLying", Cylinder{0.4, 0.5}, 0.4, lying},
      {"ConeOnBase", Cone{0.5, 0.5}, 0.5},
      {"ConeOnSide", Cone{0.5, 0.5}, side_distance, on_side},
      {"Ellipsoid", Ellipsoid{{0.5, 0.4, 0.3}}, 0.3},
      {"TaperedLying", TaperedCapsule{{0.3, 0.2}, 0.5}, tapered_height, on_cone},
      {"Hull", ConvexHull(hexagonal_corners(0.5, 0.4)), 0.4},
      {"Compound",
       Compound{{{Box{{0.5, 0.1, 0.1}}, {0, 0, 0.4}},
                 {Box{{0.1, 0.1, 0.4}}, {0.4, 0, -0.1}},
                 {Box{{0.1, 0.1, 0.4}}, {-0.4, 0, -0.1}},
                 {Cylinder{0.1, 0.4}, {0, 0.4, -0.1}},
                 {Box{{0.1, 0.3, 0.05}}, {0, 0.2, 0.35}}}},
       0.5},
  };
}

struct Floor {
  std::string name;
  Shape shape;
  Vector3 position;
};

std::vector<Floor> floors() {
  std::vector<Vector3> vertices;
  std::vector<TriangleMesh::Indices> triangles;
  const std::uint32_t side = 21;
  for (std::uint32_t j = 0; j < side; ++j) {
    for (std::uint32_t i = 0; i < side; ++i) vertices.emplace_back(0.35 * i - 3.5, 0.35 * j - 3.5, 0);
  }
  for (std::uint32_t j = 0; j + 1 < side; ++j) {
    for (std::uint32_t i = 0; i + 1 < side; ++i) {
      const std::uint32_t a = j * side + i;
      triangles.push_back({a, a + 1, a + side + 1});
      triangles.push_back({a, a + side + 1, a + side});
    }
  }
  return {
      {"HalfSpace", HalfSpace{}, Vector3::Zero()},
      {"Box", Box{{4, 4, 0.5}}, {0, 0, -0.5}},
      {"Mesh", TriangleMesh(vertices, triangles), Vector3::Zero()},
      {"HeightField", HeightField(12, 12, 0.6, 0.6, std::vector<double>(144, 0.0)), {-3.3, -3.3, 0}},
  };
}

TEST(ShapesRest, OnEveryFloor) {
  for (const Floor& floor : floors()) {
    for (const Resting& resting : resting_shapes()) {
      World world;
      world.add_body({.type = BodyType::Static, .shape = floor.shape, .position = floor.position});
      const BodyId body = world.add_body({.shape = resting.shape,
                                          .position = {0.11, 0.07, resting.height + 0.02},
                                          .orientation = resting.orientation});
      run(world, 300);
      const std::string what = resting.name + " on " + floor.name;
      EXPECT_LT(0.5 * world.velocity(body).squaredNorm(), 1e-8) << what;
      EXPECT_LT(world.angular_velocity(body).norm(), 2e-4) << what;
      EXPECT_NEAR(world.pose(body).position.z(), resting.height, 5e-3) << what;
    }
  }
}

}  // namespace
}  // namespace atl::test
