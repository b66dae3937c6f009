// Pairs of all solids: full, steady manifolds where shapes rest on each other. Axes and depths are held against the
// audit in accuracy/manifold_exactness_test.cpp.

#include <collision/narrowphase/collide.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <vector>

#include "random_solids.h"
#include "support/random.h"

namespace atl::collision {
namespace {

using test::hull_of;
using test::Random;
using test::Solids;

constexpr double pi = std::numbers::pi;

Quaternion about(const Vector3& axis, double angle) { return Quaternion(Eigen::AngleAxisd(angle, axis)); }

std::set<FeatureId> ids_of(const Manifold& manifold) {
  std::set<FeatureId> ids;
  for (int i = 0; i < manifold.count; ++i) ids.insert(manifold.points[static_cast<std::size_t>(i)].id);
  return ids;
}

constexpr ShapeKind kinds[] = {ShapeKind::Sphere, ShapeKind::Capsule, ShapeKind::Box,       ShapeKind::Cylinder,
                               ShapeKind::Cone,   ShapeKind::Hull,    ShapeKind::Ellipsoid, ShapeKind::TaperedCapsule};

// Something at rest, seen from what it lies on.
struct Rest {
  const char* name;
  Shape below, above;
  Pose pose;
  int points;
  double spread;  // of the points, at least
};

std::vector<Rest> rests(Solids& solids) {
  const Vector3 half = Vector3::Constant(0.5);
  const Shape box = Shape::box(half);
  const Shape slab = Shape::box({5, 5, 0.5});
  const Shape cube = solids.hull(box_hull(half));
  std::vector<Vector3> ring;
  for (int i = 0; i < 7; ++i) {
    for (const double z : {-0.4, 0.4}) ring.push_back({std::cos(i * 2 * pi / 7), std::sin(i * 2 * pi / 7), z});
  }
  const Shape prism = solids.hull(hull_of(ring));
  const Shape cylinder = Shape::cylinder(0.4, 0.6);
  const Shape cone = Shape::cone(0.4, 0.6);
  const Shape capsule = Shape::capsule(0.3, 0.5);
  const Quaternion upright = Quaternion::Identity();
  const Quaternion lying = about(Vector3::UnitY(), pi / 2);
  // Cone: the angle of its side with its axis is atan(0.4 / 1.2); on its side, the axis leans by that.
  const double lean = std::atan2(0.4, 1.2);
  const double side_height = 0.6 * std::sin(lean);
  return {
      {"hull on hull", cube, cube, {{0.1, 0.2, 1}, upright}, 4, 0.9},
      {"hull flush on hull", cube, cube, {{0, 0, 1}, upright}, 4, 1.4},
      {"hull half off hull", cube, cube, {{0.5, 0.5, 1}, about(Vector3::UnitZ(), 0.3)}, 4, 0.5},
      {"prism on slab", slab, prism, {{0.3, 0.2, 0.9}, about(Vector3::UnitZ(), 0.3)}, 4, 1.8},
      {"box on prism", box, prism, {{0.1, 0, -0.9}, upright}, 4, 1.3},
      {"cylinder standing", slab, cylinder, {{0.3, 0.2, 1.1}, about(Vector3::UnitZ(), 0.7)}, 4, 0.79},
      {"cylinder lying", slab, cylinder, {{0.3, 0.2, 0.9}, lying}, 2, 1.19},
      {"cylinder lying half off", box, cylinder, {{0.5, 0.2, 0.9}, lying}, 2, 0.59},
      {"cylinder on cylinder", cylinder, cylinder, {{0, 0, 1.2}, about(Vector3::UnitZ(), 0.2)}, 4, 0.79},
      {"cylinders side by side", cylinder, cylinder, {{0.8, 0, 0.3}, upright}, 2, 0.89},
      {"cone standing", slab, cone, {{0.3, 0.2, 1.1}, about(Vector3::UnitZ(), 0.7)}, 4, 0.79},
      {"cone on its side", slab, cone, {{0.3, 0.2, 0.5 + side_height}, about(Vector3::UnitY(), pi / 2 + lean)}, 2, 1.2},
      {"cone on cylinder", cylinder, cone, {{0.05, 0, 1.2}, upright}, 4, 0.7},
      {"capsule lying", capsule, slab, relative({{0.3, 0.2, 0.8}, lying}, {Vector3::Zero(), upright}), 2, 0.99},
      {"capsule along a cylinder", capsule, cylinder, {{0.7, 0, 0.2}, upright}, 2, 0.89},
      {"capsules side by side", capsule, capsule, {{0.6, 0, 0.3}, upright}, 2, 0.69}};
}

TEST(CollideConvex, WhatRestsHasAllItsPointsAndTheirIdsLast) {
  Random random(3);
  Solids solids;
  for (const Rest& rest : rests(solids)) {
    std::set<FeatureId> ids;
    std::uint32_t axis = 0;
    for (int i = 0; i < 200; ++i) {
      const Vector3 turn = random.vector(1e-7);
      const Pose second{rest.pose.position + random.vector(1e-7),
                        (rest.pose.orientation * Quaternion(1, turn.x(), turn.y(), turn.z())).normalized()};
      Manifold manifold;
      manifold.axis = axis;
      collide(rest.below, rest.above, second, 0.02, manifold);
      axis = manifold.axis;
      ASSERT_EQ(manifold.count, rest.points) << rest.name << " " << i;
      double spread = 0;
      for (int k = 0; k < manifold.count; ++k) {
        const Manifold::Point& point = manifold.points[static_cast<std::size_t>(k)];
        EXPECT_NEAR(point.separation, 0, 2e-6) << rest.name;
        spread = std::max(spread, (point.position - manifold.points[0].position).norm());
      }
      EXPECT_GT(spread, rest.spread) << rest.name;
      ids.merge(ids_of(manifold));
    }
    EXPECT_EQ(static_cast<int>(ids.size()), rest.points) << rest.name;
  }
}

// A degree of rocking, sinking or lifting within the margin keeps the face.
TEST(CollideConvex, WhatRocksKeepsItsFace) {
  Random random(4);
  Solids solids;
  for (const Rest& rest : rests(solids)) {
    if (rest.points != 4) continue;
    for (int i = 0; i < 200; ++i) {
      const Pose second{rest.pose.position * random.real(0.998, 1.002), rest.pose.orientation * random.rotation(2e-3)};
      Manifold manifold;
      collide(rest.below, rest.above, second, 0.02, manifold);
      ASSERT_EQ(manifold.count, 4) << rest.name << " " << i;
      ASSERT_EQ(ids_of(manifold).size(), 4u) << rest.name;
    }
  }
}

// Columns that have come into a wide slab in one step, far from its middle: the line of centres leads sideways, but the
// slab parts from them soonest upwards.
TEST(CollideConvex, ASlabPushesOutThroughItsNearestFace) {
  Solids solids;
  const Shape slab = Shape::box({0.5, 4, 0.02});
  std::vector<Vector3> ring;
  for (int i = 0; i < 6; ++i) {
    for (const double z : {-0.1, 0.1}) ring.push_back({0.1 * std::cos(i * pi / 3), 0.1 * std::sin(i * pi / 3), z});
  }
  for (const Shape& column : {Shape::cylinder(0.1, 0.1), solids.hull(hull_of(ring)),
                              solids.hull(box_hull(Vector3::Constant(0.1))), Shape::box(Vector3::Constant(0.1))}) {
    for (const double depth : {0.01, 0.02, 0.027, 0.034, 0.04}) {
      Manifold manifold;
      collide(slab, column, {{-0.46, 0, 0.12 - depth}, Quaternion::Identity()}, 0.01, manifold);
      ASSERT_GT(manifold.count, 2) << static_cast<int>(column.kind) << " " << depth;
      EXPECT_LT((manifold.normal.cwiseAbs() - Vector3::UnitZ()).norm(), 1e-6);
      EXPECT_NEAR(manifold.min_separation(), -depth, 1e-6);
    }
  }
}

TEST(CollideConvex, PosesThatAreNotFiniteTouchNothing) {
  Random random(7);
  Solids solids;
  for (const ShapeKind first : kinds) {
    for (const ShapeKind other : kinds) {
      if (other < first) continue;
      const Shape a = solids.random(first, random);
      const Shape b = solids.random(other, random);
      for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Manifold manifold;
        collide(a, b, {Vector3(0, bad, 0), Quaternion::Identity()}, 0.1, manifold);
        EXPECT_EQ(manifold.count, 0) << static_cast<int>(first) << " " << static_cast<int>(other);
      }
    }
  }
}

}  // namespace
}  // namespace atl::collision
