// Bounds hold the shape and touch it on every side.

#include <collision/shapes/aabb.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

// The farthest points along the axes, by the shape's own support function.
Bounds bounds_by_support(const Shape& shape, const Vector3& position, const Matrix3& rotation) {
  Bounds bounds{position, position};
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 direction = rotation.row(axis).transpose();
    bounds.upper[axis] += support_point(shape, direction).dot(direction);
    bounds.lower[axis] += support_point(shape, -direction).dot(direction);
  }
  return bounds;
}

Bounds bounds_of_points(const std::vector<Vector3>& points, const Vector3& position, const Matrix3& rotation) {
  Bounds bounds{position + rotation * points[0], position + rotation * points[0]};
  for (const Vector3& point : points) {
    bounds.lower = bounds.lower.cwiseMin(position + rotation * point);
    bounds.upper = bounds.upper.cwiseMax(position + rotation * point);
  }
  return bounds;
}

void expect_near(const Bounds& found, const Bounds& expected) {
  EXPECT_LT((found.lower - expected.lower).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((found.upper - expected.upper).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Bounds, OfSolidsAreTight) {
  Random random(1);
  std::vector<Vector3> cloud;
  for (int i = 0; i < 40; ++i) cloud.push_back(random.vector(1));
  const auto hull = build_hull(cloud);
  const Shape shapes[] = {Shape::sphere(0.7),          Shape::capsule(0.3, 1.2),
                          Shape::box({0.2, 0.5, 1.5}), Shape::cylinder(0.8, 0.3),
                          Shape::cone(0.6, 1),         Shape::convex_hull(std::get<Hull>(hull))};
  for (const Shape& shape : shapes) {
    for (int trial = 0; trial < 200; ++trial) {
      const Vector3 position = random.vector(10);
      const Matrix3 rotation = random.rotation().toRotationMatrix();
      expect_near(bounds_of(shape, position, rotation), bounds_by_support(shape, position, rotation));
    }
    const Matrix3 upright = Matrix3::Identity();
    expect_near(bounds_of(shape, Vector3::Zero(), upright), bounds_by_support(shape, Vector3::Zero(), upright));
  }
}

TEST(Bounds, OfAMeshAreTight) {
  Random random(2);
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vector3 corner = random.vector(2);
    for (int k = 0; k < 3; ++k) vertices.push_back(corner + random.vector(0.3));
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto mesh = build_triangle_mesh(vertices, triangles);
  const Shape shape = Shape::triangle_mesh(std::get<TriangleMesh>(mesh));
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3 position = random.vector(10);
    const Matrix3 rotation = random.rotation().toRotationMatrix();
    expect_near(bounds_of(shape, position, rotation), bounds_of_points(vertices, position, rotation));
  }
}

// Level, exactly those of the samples; tilted, those of the box around them.
TEST(Bounds, OfAHeightFieldHoldIt) {
  Random random(3);
  std::vector<double> heights;
  std::vector<Vector3> points;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 7; ++i) {
      heights.push_back(random.real(-1, 2));
      points.emplace_back(0.5 * i, 0.25 * j, heights.back());
    }
  }
  const auto field = build_height_field(7, 5, 0.5, 0.25, heights);
  const Shape shape = Shape::height_field(std::get<HeightField>(field));
  const Vector3 position(1, -2, 3);
  expect_near(bounds_of(shape, position, Matrix3::Identity()), bounds_of_points(points, position, Matrix3::Identity()));
  for (int trial = 0; trial < 100; ++trial) {
    const Matrix3 rotation = random.rotation().toRotationMatrix();
    const Bounds bounds = bounds_of(shape, position, rotation);
    const Bounds min = bounds_of_points(points, position, rotation);
    EXPECT_LE((bounds.lower - min.lower).maxCoeff(), 1e-12);
    EXPECT_GE((bounds.upper - min.upper).minCoeff(), -1e-12);
  }
}

TEST(Bounds, RadiiEncloseAndInscribe) {
  const Shape box = Shape::box({0.2, 3, 0.7});
  EXPECT_DOUBLE_EQ(box.bounding_radius, std::sqrt(0.04 + 9 + 0.49));
  EXPECT_DOUBLE_EQ(box.inner_radius, 0.2);
  EXPECT_DOUBLE_EQ(Shape::capsule(0.4, 1).bounding_radius, 1.4);
  EXPECT_DOUBLE_EQ(Shape::cylinder(0.3, 0.4).bounding_radius, 0.5);
  EXPECT_DOUBLE_EQ(Shape::cylinder(0.3, 0.4).inner_radius, 0.3);
  // Base 6, height 4, slant 5: a sphere of radius 1.5 touches the base and the side.
  EXPECT_DOUBLE_EQ(Shape::cone(3, 2).inner_radius, 1.5);
}

}  // namespace
}  // namespace atl::collision
