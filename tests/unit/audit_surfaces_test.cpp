// The audit of meshes and height fields against hand-computed answers, and its sweep over shapes of all kinds.

#include <atoll/errors.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "support/placing.h"

namespace atl {
namespace {

using std::numbers::pi;
using test::place;
using test::RandomPlaces;
using test::turn;

/// A flat square of n x n cells at z = 0, centred.
TriangleMesh flat_mesh(std::uint32_t cells, double size) {
  std::vector<Vector3> vertices;
  std::vector<TriangleMesh::Indices> triangles;
  const double step = size / cells;
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) vertices.emplace_back(i * step - size / 2, j * step - size / 2, 0);
  }
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t corner = j * (cells + 1) + i;
      triangles.push_back({corner, corner + 1, corner + cells + 2});
      triangles.push_back({corner, corner + cells + 2, corner + cells + 1});
    }
  }
  return TriangleMesh(vertices, triangles);
}

/// The surface of a cube of half extent 1.
TriangleMesh cube_mesh() {
  const std::vector<Vector3> vertices = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                         {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
  const std::vector<TriangleMesh::Indices> triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},
                                                        {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                                        {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  return TriangleMesh(vertices, triangles);
}

HeightField flat_field(std::uint32_t samples, double size) {
  return HeightField(samples, samples, size / (samples - 1), size / (samples - 1),
                     std::vector<double>(std::size_t{samples} * samples, 0));
}

/// Solids that stand with the given depth below z = 0 on a face, a side, an edge or round.
std::vector<PlacedShape> sunk_solids(double depth) {
  const auto sunk = [depth](const Shape& shape, double reach, const Quaternion& orientation) {
    return place(shape, {0.23, 0.11, reach - depth}, orientation);
  };
  const Quaternion upright = Quaternion::Identity();
  const Quaternion lying = turn(pi / 2, {1, 0.3, 0});
  return {sunk(Sphere{0.5}, 0.5, upright),
          sunk(Box{{0.5, 0.4, 0.3}}, 0.3, turn(0.4, {0, 0, 1})),
          sunk(Capsule{0.2, 0.6}, 0.8, upright),
          sunk(Capsule{0.2, 0.6}, 0.2, lying),
          sunk(Cylinder{0.4, 0.5}, 0.5, upright),
          sunk(Cylinder{0.4, 0.5}, 0.4, lying),
          sunk(Cone{0.4, 0.5}, 0.5, upright),
          sunk(Ellipsoid{{0.4, 0.3, 0.2}}, 0.2, upright),
          sunk(TaperedCapsule{{0.2, 0.3}, 0.4}, 0.6, upright)};
}

TEST(OverlapOfSurfaces, FlatOneCountsLikeAHalfSpace) {
  const PlacedShape plane = place(HalfSpace{}, {0, 0, 0});
  const PlacedShape coarse = place(flat_mesh(2, 8), {0, 0, 0});
  const PlacedShape fine = place(flat_mesh(40, 8), {0, 0, 0});
  const PlacedShape field = place(flat_field(41, 8), {-4, -4, 0});
  for (const double depth : {1e-5, 1e-3, 0.03}) {
    for (const PlacedShape& solid : sunk_solids(depth)) {
      ASSERT_NEAR(overlap(solid, plane), depth, 1e-14);
      EXPECT_NEAR(overlap(solid, coarse), depth, 1e-12) << solid.shape.index();
      EXPECT_NEAR(overlap(fine, solid), depth, 1e-12) << solid.shape.index();
      EXPECT_NEAR(overlap(solid, field), depth, 1e-12) << solid.shape.index();
    }
  }
  for (const PlacedShape& solid : sunk_solids(-0.01)) {
    EXPECT_LE(overlap(solid, coarse), 0);
    EXPECT_LE(overlap(solid, field), 0);
  }
}

TEST(OverlapOfSurfaces, TurnsAndMovesWithItsPose) {
  const Quaternion rotation = turn(0.9, {1, 2, -1});
  const Vector3 shift(3, -5, 7);
  for (PlacedShape solid : sunk_solids(0.02)) {
    solid.pose.position = rotation * solid.pose.position + shift;
    solid.pose.orientation = rotation * solid.pose.orientation;
    EXPECT_NEAR(overlap(solid, place(flat_mesh(8, 8), shift, rotation)), 0.02, 1e-12);
    const Vector3 corner = rotation * Vector3(-4, -4, 0) + shift;
    EXPECT_NEAR(overlap(solid, place(flat_field(9, 8), corner, rotation)), 0.02, 1e-12);
  }
}

TEST(OverlapOfSurfaces, CubeOfTrianglesFromAboveFromTheSideAndOnAnEdge) {
  const PlacedShape cube = place(cube_mesh(), {0, 0, 0});
  EXPECT_NEAR(overlap(cube, place(Box{{0.3, 0.3, 0.3}}, {0.2, 0.1, 1.25})), 0.05, 1e-12);
  EXPECT_NEAR(overlap(cube, place(Box{{0.3, 0.3, 0.3}}, {1.28, 0.1, 0.9})), 0.02, 1e-12)
      << "sideways, though its top is deep below the cube's";
  EXPECT_NEAR(overlap(cube, place(Sphere{0.5}, {1.3, 0, 1.39})), 0.5 - std::hypot(0.3, 0.39), 1e-12);
  EXPECT_NEAR(overlap(cube, place(Box{{2, 2, 0.5}}, {0, 0, 1.49})), 0.01, 1e-12) << "larger than the cube";
  EXPECT_LE(overlap(cube, place(Sphere{0.2}, {1.3, 1.3, 1.3})), 0);
  EXPECT_LE(overlap(cube, place(Sphere{0.2}, {0, 0, 0})), 0) << "a surface has no inside";
}

TEST(OverlapOfSurfaces, MeshFromBehindCountsByTheNearerSide) {
  EXPECT_NEAR(overlap(place(flat_mesh(3, 8), {0, 0, 0}), place(Sphere{0.5}, {0.1, 0.2, -0.45})), 0.05, 1e-12);
}

TEST(OverlapOfSurfaces, ValleyAndRidgeOfAHeightField) {
  // Heights |x - 2|: a valley along x = 2 between slopes of 45 degrees; its negative is a ridge.
  std::vector<double> valley, ridge;
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 5; ++i) {
      valley.push_back(std::abs(i - 2.0));
      ridge.push_back(-std::abs(i - 2.0));
    }
  }
  const PlacedShape valley_field = place(HeightField(5, 5, 1, 1, valley), {0, 0, 0});
  const PlacedShape ridge_field = place(HeightField(5, 5, 1, 1, ridge), {0, 0, 0});
  EXPECT_NEAR(overlap(valley_field, place(Sphere{0.5}, {2, 2.2, 0.45 * std::sqrt(2.0)})), 0.05, 1e-12);
  EXPECT_NEAR(overlap(ridge_field, place(Sphere{0.5}, {2, 2.2, 0.45})), 0.05, 1e-12);
  EXPECT_NEAR(overlap(ridge_field, place(Box{{0.4, 0.3, 0.2}}, {2, 2.2, 0.18})), 0.02, 1e-12);
}

TEST(OverlapOfSurfaces, SolidBelowAHeightFieldStillCounts) {
  EXPECT_GT(overlap(place(flat_field(5, 8), {-4, -4, 0}), place(Sphere{0.1}, {0.3, 0.1, -3})), 0.1);
  EXPECT_LE(overlap(place(flat_field(5, 8), {-4, -4, 0}), place(Sphere{0.1}, {4.3, 0.1, -3})), 0) << "beside it";
}

TEST(OverlapOfSurfaces, DeepestVertexUnderAHalfSpace) {
  EXPECT_NEAR(overlap(place(cube_mesh(), {0, 0, 0.8}), place(HalfSpace{}, {0, 0, 0})), 0.2, 1e-15);
  EXPECT_NEAR(overlap(place(HalfSpace{}, {0, 0, 0}), place(flat_field(3, 1), {0, 0, 0.1})), -0.1, 1e-15);
}

TEST(Penetration, SweepsShapesOfAllKinds) {
  RandomPlaces random;
  std::vector<PlacedShape> shapes;
  const std::vector<Shape> kinds = {
      Sphere{0.4},
      Capsule{0.2, 0.3},
      Box{{0.2, 0.3, 0.4}},
      Cylinder{0.3, 0.4},
      Cone{0.4, 0.4},
      Ellipsoid{{0.2, 0.3, 0.4}},
      TaperedCapsule{{0.2, 0.1}, 0.3},
      Compound{{{.shape = Sphere{0.2}, .position = {0.4, 0, 0}}, {.shape = Box{{0.4, 0.1, 0.1}}}}}};
  for (int i = 0; i < 120; ++i) {
    shapes.push_back(place(kinds[static_cast<std::size_t>(i) % kinds.size()], random.vector(-2, 2),
                           random.orientation(), i % 7 == 0 ? BodyType::Static : BodyType::Dynamic));
  }
  const Quaternion upright = Quaternion::Identity();
  shapes.push_back(place(cube_mesh(), {1, 1, 0}, turn(0.4, {1, 1, 0}), BodyType::Static));
  shapes.push_back(place(flat_field(9, 4), {-2, -2, -1.5}, upright, BodyType::Kinematic));
  shapes.push_back(place(HalfSpace{}, {0, 0, -1.8}, upright, BodyType::Static));

  std::size_t pairs = 0;
  double deepest = 0;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = i + 1; j < shapes.size(); ++j) {
      if (shapes[i].type != BodyType::Dynamic && shapes[j].type != BodyType::Dynamic) continue;
      const double depth = overlap(shapes[i], shapes[j]);
      pairs += depth > 10e-6;
      deepest = std::max(deepest, depth);
    }
  }
  const PenetrationReport report = measure_penetration(shapes);
  EXPECT_GT(pairs, 100u);
  EXPECT_EQ(report.pairs, pairs);
  EXPECT_NEAR(report.max, deepest, 1e-12);
}

TEST(Penetration, RelativeToTheSmallerBoundingRadius) {
  const auto relative = [](const Shape& shape, double reach, double radius) {
    const std::vector<PlacedShape> shapes = {
        place(shape, {0, 0, reach - 0.01}),
        place(Box{{5, 5, 1}}, {0, 0, -1}, Quaternion::Identity(), BodyType::Static)};
    EXPECT_NEAR(measure_penetration(shapes).max_relative, 0.01 / radius, 1e-12);
  };
  relative(Capsule{0.3, 0.4}, 0.7, 0.7);
  relative(Cylinder{0.3, 0.4}, 0.4, 0.5);
  relative(Cone{0.3, 0.4}, 0.4, 0.5);
  relative(Ellipsoid{{0.3, 0.6, 0.4}}, 0.4, 0.6);
  relative(TaperedCapsule{{0.3, 0.1}, 0.4}, 0.7, 0.6);
  relative(
      Compound{{{.shape = Sphere{0.5}, .position = {0, 0, 0.5}}, {.shape = Sphere{0.5}, .position = {0, 0, -0.5}}}}, 1,
      0.5 + std::sqrt(0.75));
}

}  // namespace
}  // namespace atl
