// Ellipsoids and tapered capsules against points all over their surfaces: bounds and points.

#include <collision/narrowphase/distance.h>
#include <collision/queries/ray.h>
#include <collision/shapes/aabb.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/random.h"
#include "surface_points.h"

namespace atl::collision {
namespace {

using test::Random;
using test::SurfacePoint;

constexpr double infinity = std::numeric_limits<double>::infinity();

std::vector<Shape> smooth_solids() {
  return {Shape::ellipsoid({0.5, 0.5, 0.5}),      Shape::ellipsoid({0.3, 0.4, 0.5}),
          Shape::ellipsoid({0.5, 0.5, 0.1}),      Shape::ellipsoid({0.1, 0.1, 1}),
          Shape::tapered_capsule(0.3, 0.3, 0.4),  Shape::tapered_capsule(0.4, 0.2, 0.4),
          Shape::tapered_capsule(0.1, 0.5, 0.21), Shape::tapered_capsule(0.5, 0.01, 0.6)};
}

std::string name_of(const Shape& shape) {
  return "kind " + std::to_string(static_cast<int>(shape.kind)) + " of " + std::to_string(shape.half_extents.x()) +
         " " + std::to_string(shape.half_extents.z()) + ", " + std::to_string(shape.radius) + " " +
         std::to_string(shape.top_radius);
}

Pose turned(Random& random) { return {random.vector(2), random.rotation()}; }

TEST(SmoothSolids, ReachAsFarAsTheirPointsDo) {
  Random random(1);
  for (const Shape& shape : smooth_solids()) {
    const Pose pose = turned(random);
    const Bounds bounds = bounds_of(shape, pose.position, pose.orientation.toRotationMatrix());
    Vector3 low = Vector3::Constant(infinity), high = -low;
    double inner = infinity, outer = 0;
    for (int i = 0; i < 200000; ++i) {
      const SurfacePoint at = test::random_surface_point(shape, random);
      const Vector3 place = pose.position + pose.orientation * at.point;
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
      outer = std::max(outer, at.point.norm());
      // A shape reaches along the normal of a point of its surface to that point and no farther.
      ASSERT_NEAR(reach_along(shape, at.normal), at.normal.dot(at.point), 1e-14) << name_of(shape);
      ASSERT_LT((support_point(shape, 3 * at.normal) - at.point).norm(),
                shape.kind == ShapeKind::Ellipsoid ? 1e-14 : 2);
      inner = std::min(inner, reach_along(shape, at.normal) + reach_along(shape, -at.normal));
    }
    EXPECT_GE((low - bounds.lower).minCoeff(), -1e-14) << name_of(shape);
    EXPECT_GE((bounds.upper - high).minCoeff(), -1e-14) << name_of(shape);
    EXPECT_LT((low - bounds.lower).maxCoeff(), 2e-3) << name_of(shape);
    EXPECT_LT((bounds.upper - high).maxCoeff(), 2e-3) << name_of(shape);
    EXPECT_NEAR(outer, shape.bounding_radius, 2e-3) << name_of(shape);
    // The largest ball inside is as wide as the shape is where it is narrowest.
    EXPECT_NEAR(inner, 2 * shape.inner_radius, 2e-3) << name_of(shape);
  }
}

// A point off the surface along a normal is nearest to where that stands, however deep it is, as long as all other
// surface points are farther.
TEST(SmoothSolids, PointsAreAsFarAsTheNearestOfTheirSurface) {
  Random random(2);
  for (const Shape& shape : smooth_solids()) {
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 100000; ++i) points.push_back(test::random_surface_point(shape, random));
    for (int i = 0; i < 60; ++i) {
      const Vector3 point = (i % 4 == 0 ? 0.3 : 1.5) * random.vector(shape.bounding_radius);
      double nearest = infinity, beyond = -infinity;
      for (const SurfacePoint& at : points) {
        nearest = std::min(nearest, (at.point - point).norm());
        beyond = std::max(beyond, at.normal.dot(point - at.point));
      }
      const Pose ball{point, Quaternion::Identity()};
      Distance found;
      ASSERT_TRUE(find_signed_distance(Shape::sphere(0), ball, shape, {Vector3::Zero(), Quaternion::Identity()},
                                       infinity, found));
      // The best of the planes is a lower bound, and the nearest point an upper one.
      EXPECT_GE(found.distance, beyond - 1e-12) << name_of(shape);
      EXPECT_LE(std::abs(found.distance), nearest + 1e-12) << name_of(shape);
      EXPECT_LT(found.distance - beyond, 1e-3 * shape.bounding_radius) << name_of(shape);
      const Vector3 foot = point + found.distance * found.normal;
      const Vector3 outward = -found.normal;
      EXPECT_NEAR(reach_along(shape, outward), outward.dot(foot), 1e-7 * shape.bounding_radius) << name_of(shape);
      EXPECT_LT((found.on_other - foot).norm(), 1e-7 * shape.bounding_radius) << name_of(shape);
    }
  }
}

TEST(SmoothSolids, PointsOnPlanesOfSymmetryAreMeasured) {
  const Pose origin{Vector3::Zero(), Quaternion::Identity()};
  const auto depth = [&](const Shape& shape, const Vector3& point) {
    Distance found;
    find_signed_distance(Shape::sphere(0), {point, Quaternion::Identity()}, shape, origin, infinity, found);
    return -found.distance;
  };
  // Off the middle of a flat ellipsoid, nearest to its flat sides: z^2 = c^2 (1 - x^2 / (a^2 - c^2))  with the foot at
  // x a^2 / (a^2 - c^2).
  const Shape flat = Shape::ellipsoid({1, 1, 0.5});
  EXPECT_NEAR(depth(flat, {0, 0, 0}), 0.5, 1e-15);
  const double x = 0.3, foot = x / 0.75;
  EXPECT_NEAR(depth(flat, {x, 0, 0}), std::hypot(foot - x, 0.5 * std::sqrt(1 - foot * foot)), 1e-14);
  EXPECT_NEAR(depth(flat, {0.9, 0, 0}), 0.1, 1e-14);
  EXPECT_NEAR(depth(flat, {3, 0, 0}), -2, 1e-14);
  EXPECT_NEAR(depth(flat, {0, 0, 2}), -1.5, 1e-14);
  EXPECT_NEAR(depth(flat, {0, 0, 0.1}), 0.4, 1e-14);
  EXPECT_NEAR(depth(Shape::ellipsoid({1, 2, 3}), {0, 0, 0}), 1, 1e-15);
  EXPECT_NEAR(depth(Shape::tapered_capsule(0.3, 0.1, 0.5), {0, 0, -0.5}), 0.3, 1e-15);
  EXPECT_NEAR(depth(Shape::tapered_capsule(0.3, 0.1, 0.5), {0, 0, 0}), 0.2, 1e-15);
}

}  // namespace
}  // namespace atl::collision
