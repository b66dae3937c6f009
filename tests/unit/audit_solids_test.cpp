// The audit of solids of all kinds and of compounds against a search over all directions, and against what must not
// change it.

#include <audit/placed.h>
#include <gtest/gtest.h>

#include <algorithm>
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

TEST(OverlapOfCompounds, DeepestChildCounts) {
  Compound table;
  table.children.push_back({.shape = Box{{1, 1, 0.1}}, .position = {0, 0, 1}});
  for (const double x : {-0.9, 0.9}) {
    table.children.push_back({.shape = Cylinder{0.1, 0.5}, .position = {x, 0, 0.4}});
  }
  table.children.push_back(
      {.shape = Cylinder{0.1, 0.5}, .position = {0, 0.9, 0.38}, .orientation = turn(pi, Vector3::UnitX())});
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
