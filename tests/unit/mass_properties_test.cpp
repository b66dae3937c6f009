// Mass properties of polyhedra: closed forms, how they transform, and what contacts rely on. Those of round shapes are
// in shapes_test.cpp.

#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;
using Cloud = std::vector<Vector3>;

MassProperties mass_of(const Cloud& cloud) {
  const auto result = build_hull(cloud);
  EXPECT_TRUE(std::holds_alternative<Hull>(result));
  return std::get<Hull>(result).mass;
}

void expect_near(const MassProperties& found, const MassProperties& expected, double tolerance) {
  const double size = std::cbrt(expected.volume);
  EXPECT_NEAR(found.volume, expected.volume, tolerance * expected.volume);
  EXPECT_LT((found.centre - expected.centre).norm(), tolerance * size);
  EXPECT_LT((found.unit_inertia - expected.unit_inertia).norm(), tolerance * expected.unit_inertia.norm());
}

TEST(MassProperties, OfABoxAsAHullAreTheBoxes) {
  const Vector3 half(0.2, 1.5, 0.9);
  expect_near(box_hull(half).mass, mass_properties(Shape::box(half)), 1e-14);
}

// Coxeter, "Regular polytopes", with edge a: V = a^3 / (6 sqrt 2), I = m a^2 / 20; octahedron of edge a:
// V = a^3 sqrt 2 / 3, I = m a^2 / 10.
TEST(MassProperties, OfRegularSolidsAreTheClosedForms) {
  const Cloud tetrahedron = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};  // edge 2 sqrt 2
  expect_near(mass_of(tetrahedron), {8.0 / 3, Vector3::Zero(), Matrix3::Identity() * 0.4}, 1e-14);
  const Cloud octahedron = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};  // edge sqrt 2
  expect_near(mass_of(octahedron), {4.0 / 3, Vector3::Zero(), Matrix3::Identity() * 0.2}, 1e-14);
}

// A tetrahedron with a corner at the origin: V = det / 6, centre the mean, and moments by Tonon (2004).
TEST(MassProperties, OfATetrahedronAreTheClosedForms) {
  const Cloud corners = {{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {0, 0, 5}};
  Matrix3 inertia;  // of a right corner with legs a, b, c: 3/80 (b^2 + c^2), off the diagonal ab / 80, per mass
  inertia << 34 * 3, 6, 10, 6, 29 * 3, 15, 10, 15, 13 * 3;
  expect_near(mass_of(corners), {5, {0.5, 0.75, 1.25}, inertia / 80}, 1e-14);
}

TEST(MassProperties, MoveAndTurnWithTheSolid) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    Cloud cloud;
    for (int i = 0; i < 30; ++i) cloud.push_back(random.vector(1));
    const MassProperties original = mass_of(cloud);
    const Matrix3 turn = random.rotation().toRotationMatrix();
    const Vector3 shift = random.vector(100);
    for (Vector3& point : cloud) point = shift + turn * point;
    const Matrix3 turned = turn * original.unit_inertia * turn.transpose();
    expect_near(mass_of(cloud), {original.volume, shift + turn * original.centre, turned}, 1e-11);
  }
}

TEST(MassProperties, ScaleWithTheSolid) {
  Random random(2);
  Cloud cloud;
  for (int i = 0; i < 30; ++i) cloud.push_back(random.vector(1));
  const MassProperties original = mass_of(cloud);
  for (const double factor : {1e-9, 1e-3, 1e6, 1e15}) {
    Cloud scaled;
    for (const Vector3& point : cloud) scaled.emplace_back(factor * point);
    expect_near(
        mass_of(scaled),
        {std::pow(factor, 3) * original.volume, factor * original.centre, factor * factor * original.unit_inertia},
        1e-11);
  }
}

// Contacts see no less than a third of this of a body, which so never shows of what is of one density.
TEST(MassProperties, OfSolidsAreNotLessThanTheirInnerRadiusAllows) {
  Random random(3);
  std::vector<Hull> hulls;
  for (int i = 0; i < 200; ++i) {
    Cloud cloud;
    const Vector3 size(random.magnitude(0.01, 10), random.magnitude(0.01, 10), random.magnitude(0.01, 10));
    for (int k = 0; k < 4 + i % 30; ++k) cloud.push_back(random.direction().cwiseProduct(size));
    hulls.push_back(std::get<Hull>(build_hull(cloud)));
  }
  std::vector<Shape> shapes;
  for (const Hull& hull : hulls) shapes.push_back(Shape::convex_hull(hull));
  for (int i = 0; i < 200; ++i) {
    const double a = random.magnitude(0.01, 10);
    const double b = random.magnitude(0.01, 10);
    for (const Shape& shape : {Shape::sphere(a), Shape::capsule(a, b), Shape::cylinder(a, b), Shape::cone(a, b),
                               Shape::box({a, b, random.magnitude(0.01, 10)})}) {
      shapes.push_back(shape);
    }
  }
  for (const Shape& shape : shapes) {
    const double min =
        Eigen::SelfAdjointEigenSolver<Matrix3>(mass_properties(shape).unit_inertia, Eigen::EigenvaluesOnly)
            .eigenvalues()[0];
    EXPECT_GE(min, 0.3 * shape.inner_radius * shape.inner_radius * (1 - 1e-9))
        << "kind " << static_cast<int>(shape.kind);
  }
}

}  // namespace
}  // namespace atl::collision
