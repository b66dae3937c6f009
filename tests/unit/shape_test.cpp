// Mass properties against numeric integration, and the radii.

#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace atl::collision {
namespace {

struct Integrals {
  double volume = 0;
  Matrix3 unit_inertia = Matrix3::Zero();
};

// Midpoint rule over a grid of cells in the shape's bounding cube.
template <typename Inside>
Integrals integrate(const Vector3& half, const Inside& inside) {
  constexpr int cells = 120;
  const Vector3 cell = 2 * half / cells;
  Integrals result;
  for (int i = 0; i < cells; ++i) {
    for (int j = 0; j < cells; ++j) {
      for (int k = 0; k < cells; ++k) {
        const Vector3 p = Vector3(i + 0.5, j + 0.5, k + 0.5).cwiseProduct(cell) - half;
        if (!inside(p)) continue;
        result.volume += cell.prod();
        result.unit_inertia += cell.prod() * (p.squaredNorm() * Matrix3::Identity() - p * p.transpose());
      }
    }
  }
  result.unit_inertia /= result.volume;
  return result;
}

TEST(Shape, BoxMassPropertiesMatchIntegration) {
  const Vector3 half(0.3, 1.1, 2.5);
  const Shape box = Shape::box(half);
  const Integrals expected = integrate(half, [](const Vector3&) { return true; });
  const MassProperties mass = mass_properties(box);
  EXPECT_NEAR(mass.volume, expected.volume, 1e-9 * expected.volume);
  EXPECT_LT((mass.unit_inertia - expected.unit_inertia).norm(), 2e-4 * expected.unit_inertia.norm());
}

TEST(Shape, SphereMassPropertiesMatchIntegration) {
  const double radius = 1.7;
  const Shape sphere = Shape::sphere(radius);
  const Integrals expected = integrate(Vector3::Constant(radius), [&](const Vector3& p) { return p.norm() < radius; });
  const MassProperties mass = mass_properties(sphere);
  EXPECT_NEAR(mass.volume, expected.volume, 1e-3 * expected.volume);
  EXPECT_LT((mass.unit_inertia - expected.unit_inertia).norm(), 1e-3 * expected.unit_inertia.norm());
}

// Principal moments of a solid obey the triangle inequality, a flat one with equality.
TEST(Shape, MomentsObeyTheTriangleInequality) {
  for (const Vector3& half : {Vector3(1, 1, 1), Vector3(1, 2, 1e-6), Vector3(1e-5, 1e-5, 1e3)}) {
    const Vector3 moments = mass_properties(Shape::box(half)).unit_inertia.diagonal();
    EXPECT_GT(moments.minCoeff(), 0);
    EXPECT_LE(2 * moments.maxCoeff(), moments.sum() * (1 + 1e-12));
  }
}

TEST(Shape, RadiiEncloseAndInscribe) {
  const Shape box = Shape::box({0.2, 3, 0.7});
  EXPECT_DOUBLE_EQ(box.bounding_radius, std::sqrt(0.04 + 9 + 0.49));
  EXPECT_DOUBLE_EQ(box.inner_radius, 0.2);
  const Shape sphere = Shape::sphere(0.4);
  EXPECT_DOUBLE_EQ(sphere.bounding_radius, 0.4);
  EXPECT_DOUBLE_EQ(sphere.inner_radius, 0.4);
  EXPECT_DOUBLE_EQ(Shape::capsule(0.4, 1).bounding_radius, 1.4);
  EXPECT_DOUBLE_EQ(Shape::cylinder(0.3, 0.4).bounding_radius, 0.5);
  EXPECT_DOUBLE_EQ(Shape::cylinder(0.3, 0.4).inner_radius, 0.3);
  // Base 6, height 4, slant 5: a sphere of radius 1.5 touches the base and the side.
  EXPECT_DOUBLE_EQ(Shape::cone(3, 2).inner_radius, 1.5);
}

TEST(Shape, HalfSpaceIsUnbounded) {
  const Shape half_space = Shape::half_space(Vector3::UnitX(), -2);
  EXPECT_EQ(half_space.kind, ShapeKind::HalfSpace);
  EXPECT_TRUE(std::isinf(mass_properties(half_space).volume));
  EXPECT_TRUE(std::isinf(half_space.bounding_radius));
  EXPECT_TRUE(std::isinf(half_space.inner_radius));
}

}  // namespace
}  // namespace atl::collision
