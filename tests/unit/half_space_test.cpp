// Solids on half-spaces: the points of what rests. Depths are held against the audit in
// accuracy/manifold_exactness_test.cpp.

#include <collision/narrowphase/collide.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <variant>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

// A shape at a pose of the half-space's frame, as the narrowphase sees the half-space from it.
Pose half_space_seen_from(const Pose& shape) { return relative(shape, {Vector3::Zero(), Quaternion::Identity()}); }

// A plate that sank by about its thickness has all corners within the margin. What carries it is its lower
// face: points on the upper one would leave most of the overlap unseen.
TEST(BoxOnHalfSpace, SunkPlateStandsOnItsLowerFace) {
  const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
  const Vector3 half(1, 1, 0.01);
  Manifold manifold;
  collide(Shape::box(half), plane, half_space_seen_from({Vector3(0, 0, -0.01), Quaternion::Identity()}), 0.002,
          manifold);
  ASSERT_EQ(manifold.count, 4);
  for (const Manifold::Point& point : manifold.points) EXPECT_NEAR(point.separation, -0.02, 1e-12);
}

TEST(SolidOnHalfSpace, WhatRestsHasAllItsPointsAndTheirIdsLast) {
  constexpr double pi = std::numbers::pi;
  const auto about_y = [](double angle) { return Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitY())); };
  // The cone's side leans by this against its axis, and lies that high above its middle.
  const double lean = std::atan2(0.5, 1.2);
  std::vector<Vector3> ring;
  for (int i = 0; i < 9; ++i) {
    for (const double z : {-0.4, 0.4}) ring.push_back({std::cos(i * 2 * pi / 9), std::sin(i * 2 * pi / 9), z});
  }
  const Hull prism = std::get<Hull>(build_hull(ring));
  struct Rest {
    const char* name;
    Shape solid;
    double height;
    Quaternion turn;
    int points;
  };
  const Rest rests[] = {
      {"capsule lying", Shape::capsule(0.3, 0.5), 0.3, about_y(pi / 2), 2},
      {"capsule upright", Shape::capsule(0.3, 0.5), 0.8, about_y(0), 1},
      {"cylinder standing", Shape::cylinder(0.4, 0.7), 0.7, about_y(0), 4},
      {"cylinder upside down", Shape::cylinder(0.4, 0.7), 0.7, about_y(pi), 4},
      {"cylinder lying", Shape::cylinder(0.4, 0.7), 0.4, about_y(pi / 2), 2},
      {"cylinder on its rim", Shape::cylinder(0.4, 0.7), 0.4 * std::sin(0.8) + 0.7 * std::cos(0.8), about_y(0.8), 1},
      {"cone on its base", Shape::cone(0.5, 0.6), 0.6, about_y(0), 4},
      {"cone on its side", Shape::cone(0.5, 0.6), 0.6 * std::sin(lean), about_y(pi / 2 + lean), 2},
      {"cone on its apex", Shape::cone(0.5, 0.6), 0.6, about_y(pi), 1},
      {"prism standing", Shape::convex_hull(prism), 0.4, about_y(0), 4}};
  const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
  Random random(5);
  for (const Rest& rest : rests) {
    std::set<FeatureId> ids;
    for (int i = 0; i < 200; ++i) {
      const Pose pose{Vector3(1, 2, rest.height) + random.vector(1e-7), rest.turn * random.rotation(1e-6)};
      Manifold manifold;
      collide(rest.solid, plane, half_space_seen_from(pose), 0.01, manifold);
      ASSERT_EQ(manifold.count, rest.points) << rest.name;
      for (int k = 0; k < manifold.count; ++k) {
        const Manifold::Point& point = manifold.points[static_cast<std::size_t>(k)];
        EXPECT_NEAR(point.separation, 0, 2e-6) << rest.name;
        ids.insert(point.id);
      }
    }
    EXPECT_EQ(static_cast<int>(ids.size()), rest.points) << rest.name;
  }
}

}  // namespace
}  // namespace atl::collision
