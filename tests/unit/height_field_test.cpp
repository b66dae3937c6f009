// Height fields against the same surface as a mesh, and their box query against brute force.

#include <collision/shapes/height_field.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

HeightField field_of(std::uint32_t columns, std::uint32_t rows, double dx, double dy, std::vector<double> heights) {
  auto result = build_height_field(columns, rows, dx, dy, std::move(heights));
  const std::string* problem = std::get_if<std::string>(&result);
  EXPECT_EQ(problem, nullptr) << *problem;
  return problem == nullptr ? std::get<HeightField>(std::move(result)) : HeightField{};
}

HeightField random_field(std::uint32_t columns, std::uint32_t rows, double dx, double dy, Random& random) {
  std::vector<double> heights;
  for (std::uint32_t i = 0; i < columns * rows; ++i) heights.push_back(random.real(-1, 1));
  return field_of(columns, rows, dx, dy, heights);
}

void expect_problem(std::uint32_t columns, std::uint32_t rows, double dx, double dy, std::vector<double> heights,
                    const std::string& words) {
  const auto result = build_height_field(columns, rows, dx, dy, std::move(heights));
  const std::string* problem = std::get_if<std::string>(&result);
  ASSERT_NE(problem, nullptr) << "expected a problem: " << words;
  EXPECT_NE(problem->find(words), std::string::npos) << *problem;
}

TriangleMesh as_mesh(const HeightField& field) {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t j = 0; j < field.rows; ++j) {
    for (std::uint32_t i = 0; i < field.columns; ++i) {
      vertices.emplace_back(i * field.spacing_x, j * field.spacing_y, field.height(i, j));
      if (i + 1 == field.columns || j + 1 == field.rows) continue;
      const std::uint32_t a = j * field.columns + i;
      const std::uint32_t d = a + field.columns;
      triangles.push_back({a, a + 1, d + 1});
      triangles.push_back({a, d + 1, d});
    }
  }
  auto mesh = build_triangle_mesh(vertices, triangles);
  EXPECT_TRUE(std::holds_alternative<TriangleMesh>(mesh));
  return std::get<TriangleMesh>(std::move(mesh));
}

TEST(HeightField, TrianglesAreThoseOfTheSameMesh) {
  Random random(1);
  for (const auto& [columns, rows] : {std::pair{2u, 2u}, {2u, 5u}, {6u, 2u}, {9u, 7u}}) {
    const HeightField field = random_field(columns, rows, 0.5, 0.75, random);
    const TriangleMesh mesh = as_mesh(field);
    ASSERT_EQ(field.triangle_count(), mesh.triangles.size());
    for (std::uint32_t t = 0; t < field.triangle_count(); ++t) {
      const Triangle found = field.triangle(t);
      const Triangle expected = mesh.triangle(t);
      EXPECT_EQ(found.vertices, expected.vertices);
      EXPECT_LT((found.normal - expected.normal).norm(), 1e-14);
      EXPECT_GT(found.normal.z(), 0);
      EXPECT_EQ(found.convex_edges, expected.convex_edges) << t;
      for (std::size_t e = 0; e < 3; ++e) {
        EXPECT_LT((found.neighbour_normals[e] - expected.neighbour_normals[e]).norm(), 1e-14) << t << " " << e;
      }
    }
    EXPECT_DOUBLE_EQ(field.lowest, mesh.lower.z());
    EXPECT_DOUBLE_EQ(field.highest, mesh.upper.z());
    EXPECT_GE(field.bounding_radius, mesh.bounding_radius);
  }
}

TEST(HeightField, QueryFindsInOrderWhatOverlaps) {
  Random random(2);
  const HeightField field = random_field(13, 8, 0.3, 0.7, random);
  for (int trial = 0; trial < 2000; ++trial) {
    const Vector3 lower(random.real(-2, 5), random.real(-2, 7), random.real(-2, 2));
    const Aabb box = Aabb::around(lower, lower + random.vector(2).cwiseAbs());
    std::vector<std::uint32_t> found, expected;
    field.query(box, [&](std::uint32_t t) { found.push_back(t); });
    for (std::uint32_t t = 0; t < field.triangle_count(); ++t) {
      const auto& [a, b, c] = field.triangle(t).vertices;
      const Vector3 low = a.cwiseMin(b).cwiseMin(c);
      const Vector3 high = a.cwiseMax(b).cwiseMax(c);
      bool overlaps = true;
      for (int axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(axis);
        overlaps = overlaps && low[axis] <= box.upper[i] && high[axis] >= box.lower[i];
      }
      if (overlaps) expected.push_back(t);
    }
    EXPECT_EQ(found, expected);
  }
}

// Boxes that end exactly on a grid line touch the cells on both sides.
TEST(HeightField, QueryOnAGridLineFindsBothSides) {
  const HeightField field = field_of(11, 3, 0.1, 0.1, std::vector<double>(33, 0.0));
  for (std::uint32_t i = 1; i < 10; ++i) {
    const auto x = static_cast<float>(0.1 * i);
    std::vector<std::uint32_t> found;
    field.query({{std::nextafter(x, 0.0f), 0.05f, -1}, {std::nextafter(x, 2.0f), 0.06f, 1}},
                [&](std::uint32_t t) { found.push_back(t); });
    EXPECT_EQ(found, (std::vector<std::uint32_t>{2 * i - 2, 2 * i - 1, 2 * i, 2 * i + 1}));
  }
  std::size_t corner = 0;
  field.query({{-1, -1, 0}, {0, 0, 0}}, [&](std::uint32_t) { ++corner; });
  EXPECT_EQ(corner, 2u);
}

TEST(HeightField, QueryOutsideOrWithoutABoxFindsNothing) {
  const HeightField field = field_of(3, 3, 1, 1, std::vector<double>(9, 0.0));
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  std::size_t found = 0;
  const auto count = [&](std::uint32_t) { ++found; };
  for (const Aabb& box :
       {Aabb{{3, 0, -1}, {4, 1, 1}}, Aabb{{-2, 0, -1}, {-1, 1, 1}}, Aabb{{0, 3, -1}, {1, 9, 1}}, Aabb::empty(),
        Aabb{{0, 0, 0.5f}, {2, 2, 1}}, Aabb{{nan, nan, nan}, {nan, nan, nan}}, Aabb{{1e30f, 0, -1}, {1e38f, 1, 1}}}) {
    field.query(box, count);
  }
  EXPECT_EQ(found, 0u);
  field.query({{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}}, count);
  EXPECT_EQ(found, 8u);
}

TEST(HeightField, RefusesWhatIsNoField) {
  const std::vector<double> four(4, 0.0);
  expect_problem(1, 4, 1, 1, four, "found 1 columns and 4 rows");
  expect_problem(2, 0, 1, 1, {}, "found 2 columns and 0 rows");
  expect_problem(2, 2, 0, 1, four, "found spacings of 0 and 1 m");
  expect_problem(2, 2, 1, std::numeric_limits<double>::quiet_NaN(), four, "found spacings of 1 and nan m");
  expect_problem(2, 2, 1e-17, 2.5e-7, four, "found spacings of 1e-17 and 2.5e-07 m and heights from 0 to");
  expect_problem(2, 2, 1, 1, {0, 0, 0, 1e12}, "above 1e-10 of each other and of the heights' range");
  expect_problem(2, 3, 1, 1, four, "found 4 heights, expected columns * rows = 2 * 3 = 6");
  expect_problem(2, 2, 1, 1, {0, 0, 0, -std::numeric_limits<double>::infinity()},
                 "found a height of -inf at column 1, row 1");
  expect_problem(1u << 17, 1u << 17, 1, 1, four, "2^31 cells");
}

}  // namespace
}  // namespace atl::collision
