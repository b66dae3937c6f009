// The audit of planes, of far and nearly parallel boxes, and what it reports of a scene, against hand-computed answers.

#include <atoll/errors.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "support/min_turn.h"
#include "support/placing.h"

namespace atl {
namespace {

using std::numbers::pi;
using test::place;
using test::RandomPlaces;
using test::turn;

TEST(Overlap, HalfSpaceTakesItsNormalAndOffsetFromTheBodysFrame) {
  // Turned by a quarter about x, the plane z <= 1 becomes y <= -1 about the body's position.
  const PlacedShape ground =
      place(HalfSpace{.normal = {0, 0, 5}, .offset = 1}, {0, 10, 0}, turn(pi / 2, {1, 0, 0}), BodyType::Static);
  EXPECT_NEAR(overlap(place(Sphere{0.5}, {7, 8.7, 7}), ground), 0.2, 1e-14);
  EXPECT_NEAR(overlap(ground, place(Sphere{0.5}, {7, 8, 7})), -0.5, 1e-14);
}

TEST(Overlap, BoxOnItsCornerReachesItsHalfDiagonalBelowItsCentre) {
  const PlacedShape ground = place(HalfSpace{}, Vector3::Zero(), Quaternion::Identity(), BodyType::Static);
  const Vector3 half(1, 2, 3);
  const Quaternion on_corner = test::min_turn(half, Vector3::UnitZ());
  EXPECT_NEAR(overlap(place(Box{half}, {5, 5, 3.7}, on_corner), ground), std::sqrt(14.0) - 3.7, 1e-14);
}

TEST(Overlap, NearlyParallelEdgesNeverReportLessThanTheFaces) {
  // Tilting one of two stacked cubes by an angle changes their overlap by no more than the angle times their size.
  const PlacedShape lower = place(Box{}, {0, 0, 0});
  for (double angle = 1e-18; angle < 1e-2; angle *= 3) {
    const PlacedShape upper = place(Box{}, {0.1, 0.2, 0.999}, turn(angle, {1, 2, 3}));
    EXPECT_NEAR(overlap(lower, upper), 0.001, 2 * angle + 1e-15) << angle;
  }
}

TEST(Overlap, FarFromTheOriginAsAtTheOrigin) {
  RandomPlaces random;
  const Vector3 far(1e6, -2e6, 3e6);
  for (int i = 0; i < 50; ++i) {
    const PlacedShape a = place(Box{random.vector(0.2, 2)}, random.vector(-1, 1), random.orientation());
    const PlacedShape b = place(Box{random.vector(0.2, 2)}, random.vector(-1, 1), random.orientation());
    PlacedShape far_a = a, far_b = b;
    far_a.pose.position += far;
    far_b.pose.position += far;
    EXPECT_NEAR(overlap(a, b), overlap(far_a, far_b), 4e-9);  // positions round to 2^-31 there
  }
}

TEST(Overlap, OrientationsOfAnyLengthCount) {
  Quaternion stretched = turn(0.8, {1, 1, 0});
  const PlacedShape a = place(Box{{1, 2, 3}}, {0, 0, 0}, stretched);
  stretched.coeffs() *= 1.001;
  const PlacedShape b = place(Box{{1, 2, 3}}, {0, 0, 0}, stretched);
  const PlacedShape other = place(Box{}, {1.2, 0.3, 0.1});
  EXPECT_NEAR(overlap(a, other), overlap(b, other), 1e-14);
}

std::vector<PlacedShape> random_cloud(RandomPlaces& random, int count) {
  std::vector<PlacedShape> shapes;
  for (int i = 0; i < count; ++i) {
    const BodyType type = i % 5 == 0 ? BodyType::Static : i % 7 == 0 ? BodyType::Kinematic : BodyType::Dynamic;
    Shape shape = Box{random.vector(0.1, 0.7)};
    if (i % 3 == 0) shape = Sphere{random.between(0.1, 0.7)};
    shapes.push_back(place(shape, random.vector(-3, 3), random.orientation(), type));
  }
  shapes.push_back(place(HalfSpace{.offset = -2}, {0, 0, 0}, Quaternion::Identity(), BodyType::Static));
  shapes.push_back(place(HalfSpace{.normal = {1, 0, 1}}, {-2, 0, -2}, Quaternion::Identity(), BodyType::Kinematic));
  return shapes;
}

double bounding_radius(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->radius;
  if (const auto* box = std::get_if<Box>(&shape)) return box->half_extents.norm();
  return std::numeric_limits<double>::infinity();
}

TEST(Penetration, SweepFindsWhatTestingEveryPairFinds) {
  RandomPlaces random;
  const std::vector<PlacedShape> shapes = random_cloud(random, 400);
  std::vector<double> depths;
  double sum = 0, relative = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = i + 1; j < shapes.size(); ++j) {
      if (shapes[i].type != BodyType::Dynamic && shapes[j].type != BodyType::Dynamic) continue;
      const double depth = overlap(shapes[i], shapes[j]);
      if (depth <= 10e-6) continue;
      depths.push_back(depth);
      sum += depth;
      relative =
          std::max(relative, depth / std::min(bounding_radius(shapes[i].shape), bounding_radius(shapes[j].shape)));
    }
  }
  std::sort(depths.begin(), depths.end());
  ASSERT_GT(depths.size(), 200u);

  const PenetrationReport report = measure_penetration(shapes);
  EXPECT_EQ(report.pairs, depths.size());
  EXPECT_DOUBLE_EQ(report.max, depths.back());
  EXPECT_NEAR(report.mean, sum / static_cast<double>(depths.size()), 1e-12);
  EXPECT_DOUBLE_EQ(report.p99,
                   depths[static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(depths.size()))) - 1]);
  EXPECT_DOUBLE_EQ(report.max_relative, relative);
}

/// Pairs of spheres of radius 1 with the given overlaps, each pair far from the next.
PenetrationReport measure_pairs(const std::vector<double>& depths) {
  std::vector<PlacedShape> shapes;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double y = 10.0 * static_cast<double>(i);
    shapes.push_back(place(Sphere{1}, {0, y, 0}));
    shapes.push_back(place(Sphere{1}, {2 - depths[i], y, 0}, Quaternion::Identity(), BodyType::Static));
  }
  return measure_penetration(shapes);
}

TEST(Penetration, CountsOnlyOverlapsOfMoreThanTenMicrometres) {
  const PenetrationReport report = measure_pairs({9e-6, 11e-6, -1, 0});
  EXPECT_EQ(report.pairs, 1u);
  EXPECT_NEAR(report.max, 11e-6, 1e-12);
}

TEST(Penetration, NinetyNinthPercentileIsByNearestRank) {
  for (const auto& [count, rank] : {std::pair{1, 1}, {99, 99}, {100, 99}, {101, 100}, {200, 198}, {201, 199}}) {
    std::vector<double> depths;
    for (int i = count; i >= 1; --i) depths.push_back(i * 1e-3);
    EXPECT_NEAR(measure_pairs(depths).p99, rank * 1e-3, 1e-12) << count;
  }
}

TEST(Penetration, BodyThatIsNotFiniteIsLeftOut) {
  std::vector<PlacedShape> shapes = {place(Sphere{1}, {0, 0, 0}), place(Sphere{1}, {1, 0, 0})};
  shapes.push_back(place(Sphere{1}, Vector3::Constant(std::numeric_limits<double>::quiet_NaN())));
  shapes.push_back(place(HalfSpace{.offset = -5}, {0, 0, 0}, Quaternion::Identity(), BodyType::Static));
  EXPECT_EQ(measure_penetration(shapes).pairs, 1u);
}

TEST(Rest, SplitsDisplacementIntoSinkAndDriftAndTakesTheTilt) {
  const std::vector<PlacedShape> ideal = {place(Box{}, {0, 0, 1}), place(Box{}, {0, 0, 2}), place(Box{}, {0, 0, 3}),
                                          place(HalfSpace{}, {0, 0, 0}, Quaternion::Identity(), BodyType::Static)};
  std::vector<PlacedShape> actual = ideal;
  actual[0].pose.position += Vector3(0, 0, -0.25);
  actual[1].pose.position += Vector3(0.3, -0.4, 0.1);
  actual[2].pose.orientation = turn(0.2, {1, 1, 0});
  actual[2].pose.orientation.coeffs() *= -1;  // the same orientation
  actual[3].pose.position += Vector3(9, 9, 9);

  const RestReport report = measure_rest(ideal, actual, Vector3::UnitZ());
  EXPECT_NEAR(report.sink_max, 0.25, 1e-15);
  EXPECT_NEAR(report.sink_mean, 0.15 / 3, 1e-15);
  EXPECT_NEAR(report.drift_max, 0.5, 1e-15);
  EXPECT_NEAR(report.tilt_max, 0.2, 1e-14);
}

TEST(Rest, RefusesListsOfDifferentLengthAndUpVectorsThatAreNotUnit) {
  const std::vector<PlacedShape> one = {place(Box{}, {0, 0, 1})};
  EXPECT_THROW(measure_rest(one, {}, Vector3::UnitZ()), Error);
  EXPECT_THROW(measure_rest(one, one, Vector3(0, 0, 2)), Error);
}

}  // namespace
}  // namespace atl
