// Solids on half-spaces: corners against closed forms, and the points of what rests.

#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/feature_id.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
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

Vector3 corner_of(const Vector3& half, int corner) {
  return {corner & 1 ? -half.x() : half.x(), corner & 2 ? -half.y() : half.y(), corner & 4 ? -half.z() : half.z()};
}

// Every point is a corner, with that corner's id and height; no corner is deeper than the deepest point; and
// all that are near enough are there as long as there are four at most.
TEST(BoxOnHalfSpace, PointsAreCorners) {
  Random random(2);
  int touching = 0;
  for (int i = 0; i < 5000; ++i) {
    const Shape plane = Shape::half_space(random.direction(), random.real(-5, 5));
    const Vector3 half(random.real(0.1, 1), random.real(0.1, 1), random.real(0.1, 1));
    const Quaternion orientation = random.rotation();
    const double reach = (orientation.conjugate() * plane.normal).cwiseAbs().dot(half);
    const double gap = random.real(-0.6, 0.2) * half.minCoeff();
    const double margin = random.real(0, 0.15) * half.minCoeff();
    const Pose box{(plane.offset + reach + gap) * plane.normal, orientation};
    Manifold manifold;
    EXPECT_EQ(collide(Shape::box(half), plane, half_space_seen_from(box), margin, manifold), Narrowphase::ClosedForm);

    std::set<FeatureId> near;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 p = box.position + orientation * corner_of(half, corner);
      if (plane.normal.dot(p) - plane.offset <= margin) near.insert(corner_id(corner));
    }
    std::set<FeatureId> found;
    double deepest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < manifold.count; ++k) {
      const Manifold::Point& point = manifold.points[static_cast<std::size_t>(k)];
      const auto corner = static_cast<int>(point.id - corner_id(0));
      ASSERT_TRUE(corner >= 0 && corner < 8);
      const Vector3 p = box.position + orientation * corner_of(half, corner);
      EXPECT_LT((point.position - p).norm(), 1e-12);
      EXPECT_NEAR(point.separation, plane.normal.dot(p) - plane.offset, 1e-12);
      found.insert(point.id);
      deepest = std::min(deepest, point.separation);
    }
    EXPECT_EQ(static_cast<int>(found.size()), manifold.count);
    if (near.size() <= max_points) {
      EXPECT_EQ(found, near);
    }
    if (near.empty()) continue;
    ++touching;
    EXPECT_NEAR(deepest, gap, 1e-12);
  }
  EXPECT_GT(touching, 3000);
}

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

TEST(HalfSpaces, TouchNothingOfTheirKind) {
  const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
  Manifold manifold;
  collide(plane, plane, {Vector3::Zero(), Quaternion::Identity()}, 0.1, manifold);
  EXPECT_EQ(manifold.count, 0);
}

}  // namespace
}  // namespace atl::collision
