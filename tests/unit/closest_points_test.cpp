// Closest points of convex solids, against pairs of surface points that face each other across a known gap.

#include <collision/narrowphase/distance.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "support/random.h"
#include "surface_points.h"

namespace atl::collision {
namespace {

using test::Random;

constexpr ShapeKind solids[] = {ShapeKind::Sphere, ShapeKind::Capsule, ShapeKind::Box,       ShapeKind::Cylinder,
                                ShapeKind::Cone,   ShapeKind::Hull,    ShapeKind::Ellipsoid, ShapeKind::TaperedCapsule};

bool is_polytope(const Shape& shape) {
  return shape.kind == ShapeKind::Box || shape.kind == ShapeKind::Hull || shape.kind == ShapeKind::Sphere ||
         shape.kind == ShapeKind::Capsule;
}

// Sizes up to `size`; the hull's vertices, which are all that distances depend on, lie on a sphere.
Shape random_solid(ShapeKind kind, double size, Hull& hull, Random& random) {
  const auto length = [&] { return size * random.magnitude(0.2, 1); };
  switch (kind) {
    case ShapeKind::Sphere:
      return Shape::sphere(length());
    case ShapeKind::Capsule: {
      const double radius = length();
      return Shape::capsule(radius, length());
    }
    case ShapeKind::Box: {
      const double x = length();
      const double y = length();
      return Shape::box({x, y, length()});
    }
    case ShapeKind::Cylinder: {
      const double radius = length();
      return Shape::cylinder(radius, length());
    }
    case ShapeKind::Cone: {
      const double radius = length();
      return Shape::cone(radius, length());
    }
    case ShapeKind::Ellipsoid: {
      const double x = length();
      const double y = length();
      return Shape::ellipsoid({x, y, length()});
    }
    case ShapeKind::TaperedCapsule: {
      const double bottom = length();
      const double top = length();
      return Shape::tapered_capsule(bottom, top, 0.51 * std::abs(bottom - top) + length());
    }
    default: {
      hull.vertices.resize(4 + random.below(40));
      for (Vector3& vertex : hull.vertices) vertex = size * random.direction();
      hull.prepare();
      hull.bounding_radius = size;
      return Shape::convex_hull(hull);
    }
  }
}

struct Case {
  Hull hull_first, hull_second;
  Shape first, second;
  double smaller, larger;  // bounding radii
};

Case random_case(ShapeKind first, ShapeKind second, double ratio, Random& random) {
  Case made;
  made.first = random_solid(first, 1, made.hull_first, random);
  made.second = random_solid(second, ratio, made.hull_second, random);
  made.smaller = std::min(made.first.bounding_radius, made.second.bounding_radius);
  made.larger = std::max(made.first.bounding_radius, made.second.bounding_radius);
  return made;
}

// Shapes hold pointers into the case, so it must not be copied before this.
void point_at_hulls(Case& made) {
  if (made.first.kind == ShapeKind::Hull) made.first.hull = &made.hull_first;
  if (made.second.kind == ShapeKind::Hull) made.second.hull = &made.hull_second;
}

std::string names(const Case& made, double gap) {
  return "kinds " + std::to_string(int(made.first.kind)) + " and " + std::to_string(int(made.second.kind)) +
         ", bounding radii " + std::to_string(made.first.bounding_radius) + " and " +
         std::to_string(made.second.bounding_radius) + ", gap " + std::to_string(gap);
}

// The distance is right, and the points are as far apart as it says, along the normal.
void expect_gap(const Case& made, const Pose& second, double gap, double tolerance) {
  const ClosestPoints found = closest_points(made.first, made.second, second);
  EXPECT_NEAR(found.distance, gap, tolerance) << names(made, gap);
  const Vector3 apart = found.on_second - found.on_first;
  EXPECT_NEAR(found.normal.norm(), 1, 1e-12);
  EXPECT_LT((apart - found.distance * found.normal).norm(), 1e-6 * made.larger + 1e-12 * gap) << names(made, gap);
  // A plane at the points parts the shapes by the distance: none reaches beyond its own.
  const double reach_first = reach_along(made.first, found.normal);
  const Vector3 back = second.orientation.conjugate() * -found.normal;
  const double reach_second = reach_along(made.second, back) - second.position.dot(found.normal);
  EXPECT_LE(reach_first - found.on_first.dot(found.normal), 1e-6 * made.larger) << names(made, gap);
  EXPECT_LE(reach_second + found.on_second.dot(found.normal), 1e-6 * made.larger) << names(made, gap);
}

// All pairs, with those of an ellipsoid or a tapered capsule last.
std::vector<std::pair<ShapeKind, ShapeKind>> solid_pairs() {
  std::vector<std::pair<ShapeKind, ShapeKind>> pairs;
  for (const bool smooth : {false, true}) {
    for (const ShapeKind first : solids) {
      for (const ShapeKind second : solids) {
        if ((is_smooth(first) || is_smooth(second)) == smooth) pairs.emplace_back(first, second);
      }
    }
  }
  return pairs;
}

void expect_gaps(double ratio_limit, double gap_lower, double gap_upper, int count, double polytopes, double round) {
  Random random(7);
  for (const auto& [first, second] : solid_pairs()) {
    for (int i = 0; i < count; ++i) {
      Case made = random_case(first, second, random.magnitude(1 / ratio_limit, ratio_limit * 1.0000001), random);
      point_at_hulls(made);
      const double gap = made.smaller * random.magnitude(gap_lower, gap_upper);
      const auto on_first = test::random_surface_point(made.first, random);
      const auto on_second = test::random_surface_point(made.second, random);
      const bool exact = is_polytope(made.first) && is_polytope(made.second);
      // The pose that the points give is rounded too.
      const double tolerance = (exact ? polytopes : round) * made.smaller + 1e-15 * gap;
      expect_gap(made, test::facing(on_first, on_second, gap, random), gap, tolerance);
    }
  }
}

TEST(ClosestPoints, MatchKnownGaps) { expect_gaps(3, 1e-6, 1e3, 400, 1e-11, 1e-8); }

TEST(ClosestPoints, MatchTinyGaps) { expect_gaps(3, 1e-9, 1e-6, 200, 1e-12, 1e-8); }

// Between shapes of 1 m and 10 um rounding alone takes 1e-11 of the smaller.
TEST(ClosestPoints, MatchKnownGapsOfSizesFarApart) { expect_gaps(1e5, 1e-6, 1e3, 200, 1e-8, 1e-4); }

TEST(ClosestPoints, OverlappingSolidsHaveNoDistance) {
  Random random(9);
  for (int i = 0; i < 20000; ++i) {
    Case made = random_case(solids[i % 6], solids[(i / 6) % 6], random.magnitude(0.01, 100), random);
    point_at_hulls(made);
    // A point inside of each, at the same place.
    const auto inside = [&](const Shape& shape) {
      const Vector3 surface = test::random_surface_point(shape, random).point;
      const Vector3 opposite = test::random_surface_point(shape, random).point;
      const Vector3 third = test::random_surface_point(shape, random).point;
      return Vector3(0.4 * surface + 0.35 * opposite + 0.25 * third);
    };
    const Quaternion orientation = random.rotation();
    const Pose second{inside(made.first) - orientation * inside(made.second), orientation};
    const ClosestPoints found = closest_points(made.first, made.second, second);
    EXPECT_LE(found.distance, 1e-12 * made.larger) << names(made, 0);
    EXPECT_TRUE(found.on_first.allFinite() && found.on_second.allFinite() && found.normal.allFinite());
  }
}

TEST(ClosestPoints, SolidsInTheSamePlaceAndAlignedStacks) {
  Hull hull;
  for (int corner = 0; corner < 8; ++corner) {
    hull.vertices.emplace_back(corner & 1 ? -0.5 : 0.5, corner & 2 ? -0.5 : 0.5, corner & 4 ? -0.5 : 0.5);
  }
  hull.bounding_radius = std::sqrt(0.75);
  hull.prepare();
  const Shape shapes[] = {Shape::sphere(0.5),        Shape::capsule(0.25, 0.25), Shape::box(Vector3::Constant(0.5)),
                          Shape::cylinder(0.5, 0.5), Shape::cone(0.5, 0.5),      Shape::convex_hull(hull)};
  for (const Shape& first : shapes) {
    for (const Shape& second : shapes) {
      EXPECT_EQ(closest_points(first, second, {Vector3::Zero(), Quaternion::Identity()}).distance, 0);
      // All are 1 m high.
      for (const double gap : {1e-9, 1e-6, 1e-3, 1.0, 100.0}) {
        const ClosestPoints found = closest_points(first, second, {Vector3(0, 0, 1 + gap), Quaternion::Identity()});
        EXPECT_NEAR(found.distance, gap, 1e-14 + 1e-15 * gap);
        EXPECT_LT((found.normal - Vector3::UnitZ()).norm(), 1e-6);
      }
      const ClosestPoints touching = closest_points(first, second, {Vector3(0, 0, 1), Quaternion::Identity()});
      EXPECT_LT(touching.distance, 1e-14);
      EXPECT_TRUE(touching.on_first.allFinite() && touching.on_second.allFinite() && touching.normal.allFinite());
    }
  }
}

// Capsules side by side and in line, turned out of parallel by angles around rounding.
TEST(ClosestPoints, NearlyParallelCapsules) {
  const Shape capsule = Shape::capsule(0.1, 1);
  for (double angle = 0; angle < 0.1; angle = angle == 0 ? 1e-16 : angle * 10) {
    const Quaternion turned(Eigen::AngleAxisd(angle, Vector3::UnitX()));
    // Seen along x they cross, or the first ends half a metre before the second's middle.
    for (const double along : {0.0, 0.5, 1.5}) {
      const double expected = std::hypot(0.3, std::max(0.0, along - 1) * std::sin(angle)) - 0.2;
      const Pose second{Vector3(0.3, 0, along), turned};
      EXPECT_NEAR(closest_points(capsule, capsule, second).distance, expected, 1e-12) << angle;
    }
    const double lifted = 2.5 - std::cos(angle);
    const double apart = std::hypot(lifted - 1, std::sin(angle));
    EXPECT_NEAR(closest_points(capsule, capsule, {Vector3(0, 0, 2.5), turned}).distance, apart - 0.2, 1e-12) << angle;
  }
}

// A triangle in a plane, and a solid that touches the plane from above at a known point.
TEST(ClosestPoints, MatchKnownGapsToTriangles) {
  Random random(10);
  for (int i = 0; i < 20000; ++i) {
    Case made = random_case(solids[i % 6], ShapeKind::Sphere, 1, random);
    point_at_hulls(made);
    const double size = random.magnitude(0.01, 100);
    const Vector3 a = random.vector(size);
    const Vector3 b = random.vector(size);
    const Vector3 c = random.vector(size);
    const Vector3 across = (b - a).cross(c - a);
    if (across.norm() < 0.01 * size * size) continue;
    // Over the face, or over a corner with a normal that leans outwards from both edges.
    Vector3 normal = across.normalized() * (random.chance(0.5) ? 1 : -1);
    Vector3 foot = a + 0.3 * (b - a) + 0.3 * (c - a);
    if (random.chance(0.5)) {
      foot = a;
      normal = (normal + random.real(0, 2) * (2 * a - b - c).normalized()).normalized();
      if (normal.dot(b - a) > 0 || normal.dot(c - a) > 0) continue;
    }
    const double gap = random.magnitude(1e-6, 10);
    const Pose placed = test::facing(test::random_surface_point(made.first, random), {foot, normal}, gap, random);
    std::array<Vector3, 3> triangle;
    const Vector3 corners[] = {a, b, c};
    for (std::size_t k = 0; k < 3; ++k) triangle[k] = placed.position + placed.orientation * corners[(k + i) % 3];
    const ClosestPoints found = closest_points(made.first, triangle);
    EXPECT_NEAR(found.distance, gap, 1e-9 * (1 + size)) << names(made, gap);
    const double off_plane = (placed.orientation * across.normalized()).dot(found.on_second - triangle[0]);
    EXPECT_LT(std::abs(off_plane), 1e-9 * (1 + size));
  }
}

TEST(ClosestPoints, TriangleWithoutAreaIsASegmentOrAPoint) {
  const Shape box = Shape::box(Vector3::Ones());
  const Vector3 p(3, 0.5, -0.5);
  const Vector3 q(3, 0.5, 0.5);
  EXPECT_NEAR(closest_points(box, {p, p, p}).distance, 2, 1e-14);
  EXPECT_NEAR(closest_points(box, {p, q, 0.5 * (p + q)}).distance, 2, 1e-14);
  EXPECT_NEAR(closest_points(Shape::sphere(1), {p, q, p}).distance, std::sqrt(9.25) - 1, 1e-14);
}

}  // namespace
}  // namespace atl::collision
