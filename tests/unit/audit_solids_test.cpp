// The audit of capsules, cylinders, cones, hulls and compounds against hand-computed answers, against a search over all
// directions, and against what must not change it.

#include <audit/placed.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "support/placing.h"

namespace atl {
namespace {

using std::numbers::pi;
using test::place;
using test::RandomPlaces;
using test::turn;

const Vector3 x_axis = Vector3::UnitX();
const Vector3 y_axis = Vector3::UnitY();

PlacedShape slab() { return place(Box{{5, 5, 1}}, {0, 0, -1}); }

ConvexHull box_hull(const Vector3& half) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1 ? 1 : -1) * half.x(), (i & 2 ? 1 : -1) * half.y(), (i & 4 ? 1 : -1) * half.z());
  }
  return ConvexHull(corners);
}

constexpr int kind_count = 8;

/// A shape of size about 1 of each kind of solid.
Shape random_solid(int kind, RandomPlaces& random) {
  const double radius = random.between(0.3, 1.5);
  const double half_height = random.between(0.3, 1.5);
  switch (kind) {
    case 0:
      return Sphere{radius};
    case 1:
      return Capsule{radius / 2, half_height};
    case 2:
      return Box{random.vector(0.3, 1.5)};
    case 3:
      return Cylinder{radius, half_height};
    case 4:
      return Cone{radius, half_height};
    case 5:
      return Ellipsoid{random.vector(0.3, 1.5)};
    case 6:
      return TaperedCapsule{{radius / 2, radius / 4}, half_height};
    default:
      std::vector<Vector3> points;
      for (int i = 0; i < 16; ++i) points.push_back(radius * random.direction());
      return ConvexHull(points);
  }
}

struct SolidPair {
  PlacedShape a, b;
  std::string name;
};

/// Overlapping pairs of all kinds; every third is aligned, with features parallel.
template <class Visit>
void for_random_pairs(int count, const Visit& visit) {
  RandomPlaces random;
  for (int i = 0; i < kind_count; ++i) {
    for (int j = i; j < kind_count; ++j) {
      for (int k = 0; k < count; ++k) {
        const PlacedShape a = place(random_solid(i, random), random.vector(-1, 1), random.orientation());
        PlacedShape b = place(random_solid(j, random), random.vector(-1, 1), random.orientation());
        if (k % 3 == 0) b.pose.orientation = a.pose.orientation * turn(pi / 2, Vector3::Unit(k % 2));
        if (overlap(a, b) > 0) visit(SolidPair{a, b, std::to_string(i) + "-" + std::to_string(j)});
      }
    }
  }
}

audit::Penetration penetration(const PlacedShape& a, const PlacedShape& b) {
  return audit::penetration(audit::place(a), audit::place(b));
}

TEST(OverlapOfCapsules, AlongTheLineBetweenTheSegments) {
  const PlacedShape upright = place(Capsule{0.5, 1}, {0, 0, 0});
  EXPECT_NEAR(overlap(upright, place(Sphere{0.25}, {0.7, 0, 0.9})), 0.05, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Sphere{0.25}, {0.3, 0, 1.4})), 0.25, 1e-15) << "beyond the end";
  EXPECT_NEAR(overlap(upright, place(Capsule{0.25, 2}, {0.6, 3, 0}, turn(pi / 2, x_axis))), 0.75 - std::hypot(0.6, 1),
              1e-15);
  EXPECT_NEAR(overlap(upright, place(Capsule{0.25, 2}, {0.6, 0.3, 0.2}, turn(pi / 2, x_axis))), 0.15, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Capsule{0.25, 2}, {0.7, 0, 2})), 0.05, 1e-15) << "parallel";
}

TEST(OverlapOfCapsules, SegmentsThatMeetPartAcrossBoth) {
  const PlacedShape upright = place(Capsule{0.5, 1}, {0, 0, 0});
  const audit::Penetration crossed = penetration(upright, place(Capsule{0.25, 2}, {0, 0, 0}, turn(pi / 2, x_axis)));
  EXPECT_NEAR(crossed.depth, 0.75, 1e-15);
  EXPECT_NEAR(std::abs(crossed.normal.x()), 1, 1e-15);
  const audit::Penetration same = penetration(upright, upright);
  EXPECT_NEAR(same.depth, 1, 1e-15);
  EXPECT_NEAR(same.normal.z(), 0, 1e-15);
  EXPECT_NEAR(same.normal.norm(), 1, 1e-15);
  EXPECT_NEAR(overlap(place(Sphere{1}, {0, 0, 0.3}), upright), 1.5, 1e-15);
}

TEST(OverlapOfCapsules, OnFacesEdgesAndThroughBoxes) {
  EXPECT_NEAR(overlap(slab(), place(Capsule{0.5, 1}, {0, 0, 0.4}, turn(pi / 2, y_axis))), 0.1, 1e-15) << "lying";
  EXPECT_NEAR(overlap(slab(), place(Capsule{0.5, 1}, {0, 0, 1.3})), 0.2, 1e-14) << "standing";
  EXPECT_NEAR(overlap(slab(), place(Capsule{0.5, 3}, {5.3, 0, 0.4}, turn(pi / 2, x_axis))), 0, 1e-14) << "on an edge";
  EXPECT_NEAR(overlap(slab(), place(Capsule{0.5, 1}, {0, 0, -0.2}, turn(pi / 2, y_axis))), 0.7, 1e-14) << "inside";
  const double lean = 0.3;
  EXPECT_NEAR(overlap(place(HalfSpace{}, {0, 0, 0}), place(Capsule{0.5, 1}, {0, 0, 1}, turn(lean, x_axis))),
              0.5 + std::cos(lean) - 1, 1e-15);
}

TEST(OverlapOfCylinders, StandingLyingAndLeaningOnABox) {
  EXPECT_NEAR(overlap(slab(), place(Cylinder{0.7, 1.2}, {1, 2, 1.1})), 0.1, 1e-15);
  EXPECT_NEAR(overlap(slab(), place(Cylinder{0.7, 1.2}, {1, 2, 0.6}, turn(pi / 2, y_axis))), 0.1, 1e-15);
  for (double lean = 0; lean < pi; lean += 0.1) {
    const double reach = 0.7 * std::sin(lean) + 1.2 * std::abs(std::cos(lean));
    const PlacedShape leaning = place(Cylinder{0.7, 1.2}, {1, 2, reach - 0.01}, turn(lean, {1, 2, 0}));
    EXPECT_NEAR(overlap(slab(), leaning), 0.01, 1e-14) << lean;
    EXPECT_NEAR(overlap(place(HalfSpace{}, {0, 0, 0}), leaning), 0.01, 1e-14) << lean;
  }
}

TEST(OverlapOfCylinders, SidesCapsAndRimsOfTwo) {
  const PlacedShape upright = place(Cylinder{1, 2}, {0, 0, 0});
  EXPECT_NEAR(overlap(upright, place(Cylinder{0.5, 1}, {0.8, 1.2, 0.3})), 1.5 - std::hypot(0.8, 1.2), 1e-12);
  EXPECT_NEAR(overlap(upright, place(Cylinder{0.5, 1}, {0.2, 0.1, 2.9})), 0.1, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Cylinder{0.5, 1}, {1.4, 0.3, 0.2}, turn(pi / 2, x_axis))), 0.1, 1e-12);
}

TEST(OverlapOfCylinders, CrossedRims) {
  // One leans about x, the other about y: the highest point of a rim below the lowest of a rim above, at right angles.
  const double radius = 1, half_height = 0.4;
  for (const double lean : {0.2, 0.6, 1.1}) {
    const Vector3 highest(0, radius * std::cos(lean) - half_height * std::sin(lean),
                          radius * std::sin(lean) + half_height * std::cos(lean));
    const Vector3 lowest(highest.y(), 0, -highest.z());
    const audit::Penetration rims =
        penetration(place(Cylinder{radius, half_height}, {0, 0, 0}, turn(lean, x_axis)),
                    place(Cylinder{radius, half_height}, highest - lowest - Vector3(0, 0, 0.02), turn(lean, y_axis)));
    EXPECT_NEAR(rims.depth, 0.02, 1e-12);
    EXPECT_NEAR(rims.normal.z(), 1, 1e-9);
  }
}

TEST(OverlapOfCylinders, EdgeOfABoxOnASideAndARimOnAnEdge) {
  // A box that stands on its edge, a quarter across a lying cylinder.
  const PlacedShape box = place(Box{{1, 1, 1}}, {0, 0, 0.5 + std::sqrt(2.0) - 0.05}, turn(pi / 4, x_axis));
  EXPECT_NEAR(overlap(place(Cylinder{0.5, 3}, {0, 0, 0}, turn(pi / 2, x_axis)), box), 0.05, 1e-12);
  // A wheel that has rolled onto an edge along its own axis, from above.
  const PlacedShape wheel = place(Cylinder{1, 0.2}, {0, 0, 1 + std::sqrt(2.0) - 0.05}, turn(pi / 2, x_axis));
  EXPECT_NEAR(overlap(place(Box{{1, 1, 1}}, {0, 0, 0}, turn(pi / 4, y_axis)), wheel), 0.05, 1e-12);
}

TEST(OverlapOfCylinders, SphereInFrontOfSideCapAndRimAndInside) {
  const PlacedShape upright = place(Cylinder{1, 2}, {0, 0, 0});
  EXPECT_NEAR(overlap(upright, place(Sphere{0.5}, {0, 1.4, 1})), 0.1, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Sphere{0.5}, {0.5, 0, 2.4})), 0.1, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Sphere{0.6}, {1.3, 0, 2.4})), 0.1, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Sphere{0.5}, {0.8, 0, 0})), 0.7, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Sphere{0.5}, {0, 0, 0})), 1.5, 1e-15);
  EXPECT_NEAR(overlap(upright, place(Capsule{0.5, 1}, {1.3, 0, 3.4})), 0.5 - 0.5, 1e-15);
}

TEST(OverlapOfCones, BaseSideAndApexOnABox) {
  const double radius = 0.6, half_height = 0.8;  // the side is 10 : 3 units long, its normal 0.6 : 1.6 steep
  const double slant = std::hypot(radius, 2 * half_height);
  EXPECT_NEAR(overlap(slab(), place(Cone{radius, half_height}, {1, 1, 0.7})), 0.1, 1e-15) << "on its base";
  const PlacedShape on_apex = place(Cone{radius, half_height}, {1, 1, 0.7}, turn(pi, x_axis));
  EXPECT_NEAR(overlap(slab(), on_apex), 0.1, 1e-14);
  EXPECT_NEAR(overlap(place(HalfSpace{}, {0, 0, 0}), on_apex), 0.1, 1e-14);
  // Lying on its side, the middle of its axis is half_height * radius / slant above the ground.
  const double lay = pi / 2 + std::asin(radius / slant);
  const double height = half_height * radius / slant;
  EXPECT_NEAR(overlap(slab(), place(Cone{radius, half_height}, {1, 1, height - 0.05}, turn(lay, y_axis))), 0.05, 1e-13);
}

TEST(OverlapOfCones, SideOfAConeAgainstASphereAndAnotherCone) {
  const double slant = std::sqrt(17.0);  // radius 1, height 4
  const Vector3 normal(4 / slant, 0, 1 / slant);
  const Vector3 middle(0.5, 0, 0);
  const PlacedShape cone = place(Cone{1, 2}, {0, 0, 0});
  EXPECT_NEAR(overlap(cone, place(Sphere{0.5}, middle + 0.4 * normal)), 0.1, 1e-15);
  EXPECT_NEAR(overlap(cone, place(Sphere{0.5}, {0, 0, 2.3})), 0.2, 1e-15) << "above the apex";
  EXPECT_NEAR(overlap(cone, place(Sphere{0.5}, {1.3, 0, -2.4})), 0, 1e-15) << "at the rim";
  // Head down next to the first, side on side.
  const Vector3 beside = 2 * middle.dot(normal) * normal - 0.1 * normal;
  const audit::Penetration sides = penetration(cone, place(Cone{1, 2}, beside, turn(pi, y_axis)));
  EXPECT_NEAR(sides.depth, 0.1, 1e-12);
  EXPECT_NEAR(sides.normal.dot(normal), 1, 1e-9);
}

TEST(OverlapOfHulls, BoxAsAHullIsABox) {
  RandomPlaces random;
  for (int kind = 0; kind < kind_count; ++kind) {
    for (int i = 0; i < 40; ++i) {
      const Vector3 half = random.vector(0.3, 1.5);
      const PlacedShape box = place(Box{half}, random.vector(-1, 1), random.orientation());
      const PlacedShape hull = place(box_hull(half), box.pose.position, box.pose.orientation);
      const PlacedShape other = place(random_solid(kind, random), random.vector(-1, 1), random.orientation());
      EXPECT_NEAR(overlap(hull, other), overlap(box, other), 1e-9) << kind;
    }
  }
}

TEST(OverlapOfHulls, TetrahedronOnItsTip) {
  const std::vector<Vector3> points = {{0, 0, -1}, {1, 0, 1}, {-1, 1, 1}, {-1, -1, 1}, {0, 0, 0.5}};
  const ConvexHull tetrahedron(points);
  EXPECT_NEAR(overlap(slab(), place(tetrahedron, {0, 0, 0.9})), 0.1, 1e-14);
  EXPECT_NEAR(overlap(place(HalfSpace{}, {0, 0, 0}), place(tetrahedron, {0, 0, 0.9})), 0.1, 1e-15);
  EXPECT_NEAR(overlap(place(Sphere{0.5}, {0, 0, -1.4}), place(tetrahedron, {0, 0, 0})), 0.1, 1e-14);
}

TEST(OverlapOfCompounds, DeepestChildCounts) {
  Compound table;
  table.children.push_back({.shape = Box{{1, 1, 0.1}}, .position = {0, 0, 1}});
  for (const double x : {-0.9, 0.9}) {
    table.children.push_back({.shape = Cylinder{0.1, 0.5}, .position = {x, 0, 0.4}});
  }
  table.children.push_back({.shape = Cylinder{0.1, 0.5}, .position = {0, 0.9, 0.38}, .orientation = turn(pi, x_axis)});
  EXPECT_NEAR(overlap(place(table, {0, 0, 0.09}), slab()), 0.03, 1e-15) << "the third leg is longer by 2 cm";
  const PlacedShape turned = place(table, {0, 0, 0}, turn(pi / 2, {0, 0, 1}));
  EXPECT_NEAR(overlap(turned, place(Sphere{0.5}, {-1.4, 0, 0.3})), 0.1, 1e-14) << "the third leg has turned to -x";
  EXPECT_NEAR(overlap(turned, turned), 0.2, 1e-14);
}

double along(const audit::Solid& a, const audit::Solid& b, const Vector3& normal) {
  return reach(a, normal) + reach(b, -normal) - normal.dot(b.centre - a.centre);
}

TEST(OverlapOfSolids, MatchesASearchOverAllDirections) {
  RandomPlaces random(7);
  int pairs = 0;
  for_random_pairs(9, [&](const SolidPair& pair) {
    const audit::Solid a = std::get<audit::PlacedSolids>(audit::place(pair.a)).front();
    const audit::Solid b = std::get<audit::PlacedSolids>(audit::place(pair.b)).front();
    const audit::Penetration exact = audit::penetration(a, b);
    EXPECT_NEAR(exact.normal.norm(), 1, 1e-14);
    EXPECT_NEAR(along(a, b, exact.normal), exact.depth, 1e-12) << pair.name;
    std::vector<std::pair<double, Vector3>> samples;
    for (int i = 0; i < 1000; ++i) {
      const Vector3 direction = random.direction();
      samples.emplace_back(along(a, b, direction), direction);
    }
    std::partial_sort(samples.begin(), samples.begin() + 8, samples.end(),
                      [](const auto& x, const auto& y) { return x.first < y.first; });
    for (std::size_t i = 0; i < 8; ++i) {
      auto [best, direction] = samples[i];
      for (double radius = 0.1; radius > 1e-8; radius *= 0.96) {
        const Vector3 other = (direction + radius * random.direction()).normalized();
        if (const double depth = along(a, b, other); depth < best) {
          best = depth;
          direction = other;
        }
      }
      EXPECT_LE(exact.depth, best + 1e-7) << pair.name;
    }
    ++pairs;
  });
  EXPECT_GT(pairs, 100);
}

TEST(OverlapOfSolids, PartsThePairAndNoMore) {
  for_random_pairs(12, [&](const SolidPair& pair) {
    const audit::Penetration found = penetration(pair.a, pair.b);
    PlacedShape parted = pair.b;
    parted.pose.position += found.depth * found.normal;
    EXPECT_NEAR(overlap(pair.a, parted), 0, 1e-9) << pair.name;
    parted.pose.position = pair.b.pose.position + 0.5 * found.depth * found.normal;
    EXPECT_NEAR(overlap(pair.a, parted), found.depth / 2, 1e-9) << pair.name;
  });
}

TEST(OverlapOfSolids, DoesNotDependOnOrderOrFrame) {
  const Quaternion rotation = turn(1.1, {3, -2, 1});
  const Vector3 shift(10, -20, 30);
  for_random_pairs(12, [&](const SolidPair& pair) {
    const audit::Penetration found = penetration(pair.a, pair.b);
    EXPECT_NEAR(overlap(pair.b, pair.a), found.depth, 1e-9) << pair.name;
    PlacedShape a = pair.a, b = pair.b;
    for (PlacedShape* shape : {&a, &b}) {
      shape->pose.position = rotation * shape->pose.position + shift;
      shape->pose.orientation = rotation * shape->pose.orientation;
    }
    EXPECT_NEAR(overlap(a, b), found.depth, 1e-9) << pair.name;
  });
}

TEST(OverlapOfSolids, ApartIsNegativeAndNoMoreThanTheGap) {
  RandomPlaces random;
  for_random_pairs(6, [&](const SolidPair& pair) {
    const audit::Penetration found = penetration(pair.a, pair.b);
    for (const double gap : {1e-6, 1e-3, 0.3}) {
      PlacedShape parted = pair.b;
      parted.pose.position += (found.depth + gap) * found.normal;
      const double depth = overlap(pair.a, parted);
      EXPECT_LE(depth, -gap * (1 - 1e-6)) << pair.name << " are apart along a known axis";
      EXPECT_GE(depth, -gap * (1 + 1e-6)) << pair.name << " are no farther than that";
    }
  });
}

}  // namespace
}  // namespace atl
