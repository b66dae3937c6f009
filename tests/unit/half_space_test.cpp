// Spheres and boxes on half-spaces, against closed forms.

#include <collision/collide.h>
#include <collision/feature_id.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "random.h"

namespace atl::collision {
namespace {

using test::Random;

// A shape at a pose of the half-space's frame, as the narrowphase sees the half-space from it.
Pose half_space_seen_from(const Pose& shape) { return relative(shape, {Vector3::Zero(), Quaternion::Identity()}); }

Vector3 corner_of(const Vector3& half, int corner) {
  return {corner & 1 ? -half.x() : half.x(), corner & 2 ? -half.y() : half.y(), corner & 4 ? -half.z() : half.z()};
}

TEST(SphereOnHalfSpace, MatchesDistanceFromThePlane) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Shape plane = Shape::half_space(random.direction(), random.real(-5, 5));
    const double radius = random.magnitude(0.01, 10);
    const double separation = random.real(-3, 0.5) * radius;
    const double margin = random.real(0, 0.4) * radius;
    const Vector3 along = plane.normal.unitOrthogonal() * random.real(-10, 10);
    const Pose sphere{(plane.offset + radius + separation) * plane.normal + along, random.rotation()};
    Manifold manifold;
    EXPECT_EQ(collide(Shape::sphere(radius), plane, half_space_seen_from(sphere), margin, manifold),
              Narrowphase::ClosedForm);
    if (separation > margin) {
      EXPECT_EQ(manifold.count, 0);
      continue;
    }
    ASSERT_EQ(manifold.count, 1);
    EXPECT_TRUE(manifold.reference_is_second);
    EXPECT_EQ(manifold.normal, plane.normal);
    EXPECT_NEAR(manifold.points[0].separation, separation, 1e-12 * (20 + radius));
    EXPECT_LT((manifold.points[0].position - sphere.position + radius * plane.normal).norm(), 1e-12 * (20 + radius));
  }
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

TEST(BoxOnHalfSpace, FlatFaceHasItsFourCornersWhateverTheNoise) {
  Random random(3);
  const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
  const std::set<FeatureId> lower = {corner_id(4), corner_id(5), corner_id(6), corner_id(7)};
  for (int i = 0; i < 1000; ++i) {
    const Pose box{Vector3(0, 0, 0.5) + random.vector(1e-9), random.rotation(1e-9)};
    Manifold manifold;
    collide(Shape::box(Vector3::Constant(0.5)), plane, half_space_seen_from(box), 0.025, manifold);
    std::set<FeatureId> found;
    for (int k = 0; k < manifold.count; ++k) found.insert(manifold.points[static_cast<std::size_t>(k)].id);
    ASSERT_EQ(found, lower);
  }
}

TEST(BoxOnHalfSpace, PoseThatIsNotFiniteTouchesNothing) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
  Manifold manifold;
  collide_box_half_space(Vector3::Ones(), plane, {Vector3(0, 0, nan), Quaternion::Identity()}, 0.1, manifold);
  EXPECT_EQ(manifold.count, 0);
  collide_box_half_space(Vector3::Ones(), plane, {Vector3::Zero(), Quaternion(nan, 0, 0, 0)}, 0.1, manifold);
  EXPECT_EQ(manifold.count, 0);
}

TEST(HalfSpaces, TouchNothingOfTheirKind) {
  const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
  Manifold manifold;
  collide(plane, plane, {Vector3::Zero(), Quaternion::Identity()}, 0.1, manifold);
  EXPECT_EQ(manifold.count, 0);
}

}  // namespace
}  // namespace atl::collision
