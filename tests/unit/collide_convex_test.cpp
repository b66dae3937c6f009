// Pairs of all solids: axes and depths against sampled directions and exact tests, and full, steady manifolds where
// shapes rest on each other.

#include <collision/narrowphase/collide.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <utility>
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

double separation_along(const Shape& a, const Shape& b, const Pose& second, const Vector3& n) {
  return n.dot(second.position) - reach_along(a, n) - reach_along(b, -(second.orientation.conjugate() * n));
}

// Evenly spread over the sphere.
std::vector<Vector3> directions(int count) {
  std::vector<Vector3> result;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count;
    const double r = std::sqrt(1 - z * z);
    const double angle = i * pi * (3 - std::sqrt(5.0));
    result.push_back({r * std::cos(angle), r * std::sin(angle), z});
  }
  return result;
}

// The greatest value around a direction, by steps to eight sides that shrink where none leads up.
template <typename Function>
double climb(const Function& value, Vector3 n) {
  double best = value(n);
  double step = 0.05;
  for (int i = 0; i < 200 && step > 1e-6; ++i) {
    const Vector3 u = n.unitOrthogonal();
    const Vector3 v = n.cross(u);
    Vector3 higher = n;
    for (int k = 0; k < 8; ++k) {
      const Vector3 near = (n + step * (std::cos(k * pi / 4) * u + std::sin(k * pi / 4) * v)).normalized();
      const double there = value(near);
      if (there <= best) continue;
      best = there;
      higher = near;
    }
    if (higher == n) step *= 0.7;
    n = higher;
  }
  return best;
}

// A random pose at which the greatest separation along the given directions is `gap`.
Pose placed(Random& random, const Shape& a, const Shape& b, double gap, const std::vector<Vector3>& axes) {
  Pose second{random.direction(), random.rotation()};
  const Vector3 direction = second.position;
  std::vector<double> reach;
  for (const Vector3& n : axes) {
    reach.push_back(reach_along(a, n) + reach_along(b, -(second.orientation.conjugate() * n)));
  }
  double near = 0;
  double far = 2 * (a.bounding_radius + b.bounding_radius);
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (near + far);
    double separation = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < axes.size(); ++k) {
      separation = std::max(separation, middle * axes[k].dot(direction) - reach[k]);
    }
    (separation < gap ? near : far) = middle;
  }
  second.position = near * direction;
  return second;
}

Vector3 hull_normal_of(const Manifold& manifold, const Pose& second) {
  return manifold.reference_is_second ? Vector3(-(second.orientation * manifold.normal)) : manifold.normal;
}

std::set<FeatureId> ids_of(const Manifold& manifold) {
  std::set<FeatureId> ids;
  for (int i = 0; i < manifold.count; ++i) ids.insert(manifold.points[static_cast<std::size_t>(i)].id);
  return ids;
}

constexpr ShapeKind kinds[] = {ShapeKind::Sphere, ShapeKind::Capsule, ShapeKind::Box,       ShapeKind::Cylinder,
                               ShapeKind::Cone,   ShapeKind::Hull,    ShapeKind::Ellipsoid, ShapeKind::TaperedCapsule};

// All but boxes with boxes; those with an ellipsoid or a tapered capsule last.
std::vector<std::pair<ShapeKind, ShapeKind>> pairs_of_kinds() {
  std::vector<std::pair<ShapeKind, ShapeKind>> pairs;
  for (const bool smooth : {false, true}) {
    for (const ShapeKind first : kinds) {
      for (const ShapeKind other : kinds) {
        if (other < first || (first == ShapeKind::Box && other == ShapeKind::Box)) continue;
        if ((is_smooth(first) || is_smooth(other)) == smooth) pairs.emplace_back(first, other);
      }
    }
  }
  return pairs;
}

// No direction parts a pair better than its normal does: none of those spread over the sphere, nor of those
// around the normal; and the deepest point's separation is the one along the normal. Boxes have a test of their
// own. A face that stands in for the best axis may be deeper by a fiftieth of the size.
TEST(CollideConvex, NoDirectionPartsShallowPairsBetter) {
  Random random(1);
  const std::vector<Vector3> coarse = directions(200);
  const std::vector<Vector3> fine = directions(400);
  Solids solids;
  int touching = 0;
  int stand_ins = 0;
  for (const auto& [first, other] : pairs_of_kinds()) {
    for (int i = 0; i < 30; ++i) {
      const Shape a = solids.random(first, random);
      const Shape b = solids.random(other, random);
      const double size = std::min(a.inner_radius, b.inner_radius);
      const Pose second = placed(random, a, b, random.real(-0.1, 0) * size, coarse);
      Manifold manifold;
      collide(a, b, second, 0.05 * size, manifold);
      const std::string what = std::to_string(static_cast<int>(first)) + " " + std::to_string(static_cast<int>(other)) +
                               " #" + std::to_string(i);
      const auto along = [&](const Vector3& n) { return separation_along(a, b, second, n); };
      Vector3 start = fine[0];
      for (const Vector3& n : fine) {
        if (along(n) > along(start)) start = n;
      }
      double best = climb(along, start);
      if (manifold.count == 0) {
        EXPECT_GT(best, 0) << what;
        continue;
      }
      ++touching;
      const Vector3 normal = hull_normal_of(manifold, second);
      const double found = separation_along(a, b, second, normal);
      best = std::max(best, climb(along, normal));
      const bool stand_in = best > found + 1e-4 * size;
      stand_ins += stand_in;
      ASSERT_LE(best, found + (stand_in && manifold.axis != 0 ? 0.02 : 1e-4) * size) << what;
      ASSERT_NEAR(manifold.least_separation(), stand_in ? best : found, (stand_in ? 0.02 : 1e-4) * size) << what;
    }
  }
  EXPECT_GT(touching, 300);
  EXPECT_LT(stand_ins, touching / 20);
}

// Separating-axis test over all faces and all pairs of edges.
double exact_separation(const Hull& a, const Hull& b, const Pose& second, Vector3& normal) {
  const Shape first = Shape::convex_hull(a);
  const Shape other = Shape::convex_hull(b);
  double best = -std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vector3& n) {
    const double separation = separation_along(first, other, second, n);
    if (separation <= best) return;
    best = separation;
    normal = n;
  };
  for (const Hull::Plane& plane : a.planes) consider(plane.normal);
  for (const Hull::Plane& plane : b.planes) consider(-(second.orientation * plane.normal));
  for (const Hull::Edge& e : a.edges) {
    const Vector3 u = a.vertices[e.head] - a.vertices[e.tail];
    for (const Hull::Edge& f : b.edges) {
      const Vector3 cross = u.cross(second.orientation * (b.vertices[f.head] - b.vertices[f.tail]));
      if (cross.norm() < 1e-9) continue;
      consider(cross.normalized());
      consider(-cross.normalized());
    }
  }
  return best;
}

TEST(CollideConvex, OverlappingHullsHaveTheExactAxis) {
  Random random(2);
  Solids solids;
  const std::vector<Vector3> coarse = directions(200);
  int shallow = 0;
  for (int i = 0; i < 240; ++i) {
    const Shape a = solids.random(ShapeKind::Hull, random);
    const Shape b = solids.random(ShapeKind::Hull, random);
    const bool deep = i % 2 == 1;
    const Pose second =
        placed(random, a, b, random.real(deep ? -1 : -0.15, deep ? -0.3 : -0.05) * a.inner_radius, coarse);
    Vector3 normal = Vector3::Zero();
    const double exact = exact_separation(*a.hull, *b.hull, second, normal);
    if (exact > -1e-4) continue;
    Manifold manifold;
    collide(a, b, second, 0.01, manifold);
    ASSERT_GT(manifold.count, 0) << i;
    const double found = separation_along(a, b, second, hull_normal_of(manifold, second));
    if (deep) {
      EXPECT_GE(found, 1.5 * exact) << i;
      continue;
    }
    const bool stand_in = manifold.axis != 0 && found < exact - 1e-9;
    EXPECT_NEAR(found, exact, stand_in ? 0.02 * a.inner_radius : 1e-9) << i;
    shallow += !stand_in;
  }
  EXPECT_GT(shallow, 40);
}

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

TEST(CollideConvex, TiltedCylinderTouchesWithItsLowestRimPoint) {
  for (const double tilt : {1e-3, 0.01, 0.1, 0.5, 1.0}) {
    const Shape slab = Shape::box({5, 5, 0.5});
    const Shape cylinder = Shape::cylinder(0.4, 0.6);
    const double lowest = 0.4 * std::sin(tilt) + 0.6 * std::cos(tilt);
    const Pose second{{0.2, 0.3, 0.5 + lowest - 0.01}, about(Vector3::UnitX(), tilt)};
    Manifold manifold;
    collide(slab, cylinder, second, 0.01, manifold);
    ASSERT_GT(manifold.count, 0) << tilt;
    EXPECT_LT((hull_normal_of(manifold, second) - Vector3::UnitZ()).norm(), 1e-12) << tilt;
    EXPECT_NEAR(manifold.least_separation(), -0.01, 1e-12) << tilt;
  }
}

// Cylinder against the edge of a box: axis across both, a closed form.
TEST(CollideConvex, CylinderOnAnEdge) {
  const Shape box = Shape::box({0.5, 2, 0.5});
  const Shape cylinder = Shape::cylinder(0.25, 1);
  for (const double yaw : {0.3, 0.7, 1.2}) {
    // Its axis turned about the diagonal that leads out of the edge, and across that diagonal.
    const Vector3 out = Vector3(1, 0, 1).normalized();
    const Quaternion turn = about(out, yaw) * about(Vector3::UnitX(), pi / 2);
    const double gap = -0.01;
    const Pose second{Vector3(0.5, 0, 0.5) + (0.25 + gap) * out, turn};
    Manifold manifold;
    collide(box, cylinder, second, 0.01, manifold);
    ASSERT_EQ(manifold.count, 1);
    EXPECT_LT((hull_normal_of(manifold, second) - out).norm(), 1e-9);
    EXPECT_NEAR(manifold.points[0].separation, gap, 1e-9);
    EXPECT_LT((manifold.points[0].position - Vector3(0.5, 0, 0.5) - gap * out).norm(), 1e-4);
  }
}

TEST(CollideConvex, CapsulesMatchTheDistanceOfTheirSegments) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const Shape a = Shape::capsule(random.real(0.1, 0.5), random.real(0.1, 1));
    const Shape b = Shape::capsule(random.real(0.1, 0.5), random.real(0.1, 1));
    const Pose second{random.vector(1.2), random.rotation()};
    // From the first's segment a point's distance is closed form, and convex along the second: cut to two thirds.
    const Vector3 v = second.orientation * Vector3::UnitZ();
    const auto on_first = [&](const Vector3& p) { return std::clamp(p.z(), -a.half_height, a.half_height); };
    double low = -b.half_height;
    double high = b.half_height;
    const auto distance = [&](double t) {
      const Vector3 p = second.position + t * v;
      return (p - on_first(p) * Vector3::UnitZ()).norm();
    };
    for (int k = 0; k < 100; ++k) {
      const double third = (high - low) / 3;
      if (distance(low + third) < distance(high - third)) {
        high -= third;
      } else {
        low += third;
      }
    }
    const double expected = distance(low) - a.radius - b.radius;
    Manifold manifold;
    collide(a, b, second, 0.1, manifold);
    if (expected > 0.1 + 1e-9) {
      EXPECT_EQ(manifold.count, 0) << i;
    } else if (expected < 0.1 - 1e-9) {
      ASSERT_GT(manifold.count, 0) << i;
      EXPECT_NEAR(manifold.least_separation(), expected, 1e-3 * std::min(a.radius, b.radius)) << i;
    }
  }
}

// Coincident, touching, flat, needle-like, and 1e5 times as large: finite, near both shapes, within the margin,
// with ids of their own.
TEST(CollideConvex, ExtremePairsStaySane) {
  Random random(6);
  Solids solids;
  for (int i = 0; i < 6000; ++i) {
    const auto extreme = [&](double s) {
      const double thin = s * random.magnitude(1e-3, 1);
      switch (random.below(6)) {
        case 0:
          return Shape::capsule(random.chance(0.5) ? thin : s, s);
        case 1:
          return Shape::box({s, thin, random.chance(0.5) ? thin : s});
        case 2:
          return Shape::cylinder(thin, s);
        case 3:
          return Shape::cylinder(s, thin);
        case 4:
          return Shape::cone(random.chance(0.5) ? thin : s, random.chance(0.5) ? thin : s);
        default:
          return solids.hull(box_hull({s, thin, s}));
      }
    };
    Shape a = extreme(1);
    Shape b = random.chance(0.2) ? a : extreme(random.chance(0.5) ? 1 : random.magnitude(1e-5, 1e5));
    if (b.kind < a.kind) std::swap(a, b);
    Pose second{Vector3::Zero(), random.chance(0.5) ? Quaternion(Quaternion::Identity()) : random.rotation()};
    const double size = std::min(a.inner_radius, b.inner_radius);
    const bool coincident = random.chance(0.2);
    if (!coincident) {
      const Vector3 n = random.chance(0.5) ? Vector3(Vector3::UnitZ()) : random.direction();
      const double touch = reach_along(a, n) + reach_along(b, -(second.orientation.conjugate() * n));
      second.position = (touch + random.real(-0.1, 0.03) * size * (random.chance(0.7) ? 1 : 0)) * n;
    }
    Manifold manifold;
    const double margin = 0.05 * size;
    collide(a, b, second, margin, manifold);
    if (coincident) {
      ASSERT_GT(manifold.count, 0) << i;
    }
    ASSERT_LE(manifold.count, max_points);
    if (manifold.count == 0) continue;
    ASSERT_NEAR(manifold.normal.norm(), 1, 1e-9) << i;
    ASSERT_EQ(static_cast<int>(ids_of(manifold).size()), manifold.count) << i;
    for (int k = 0; k < manifold.count; ++k) {
      const Manifold::Point& point = manifold.points[static_cast<std::size_t>(k)];
      ASSERT_TRUE(point.position.allFinite() && std::isfinite(point.separation)) << i;
      ASSERT_LE(point.separation, margin) << i;
      ASSERT_LE(point.position.norm(), 1.05 * (a.bounding_radius + b.bounding_radius)) << i;
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
