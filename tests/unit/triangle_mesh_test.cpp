// Meshes: whose triangles are neighbours, the tree against brute force, and what is refused. Edges that bend are those
// of surface_contacts_test.cpp.

#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;
using Vertices = std::vector<Vector3>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

TriangleMesh mesh_of(const Vertices& vertices, const Triangles& triangles) {
  auto result = build_triangle_mesh(vertices, triangles);
  const std::string* problem = std::get_if<std::string>(&result);
  EXPECT_EQ(problem, nullptr) << *problem;
  return problem == nullptr ? std::get<TriangleMesh>(std::move(result)) : TriangleMesh{};
}

void expect_problem(const Vertices& vertices, const Triangles& triangles, const std::string& words) {
  const auto result = build_triangle_mesh(vertices, triangles);
  const std::string* problem = std::get_if<std::string>(&result);
  ASSERT_NE(problem, nullptr) << "expected a problem: " << words;
  EXPECT_NE(problem->find(words), std::string::npos) << *problem;
}

const Vertices cube_vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
const Triangles cube_triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                  {2, 3, 7}, {2, 7, 6}, {1, 2, 6}, {1, 6, 5}, {3, 0, 4}, {3, 4, 7}};

// A surface over a grid of n x n cells with random heights; corners of triangles not shared where `soup`.
struct Surface {
  Vertices vertices;
  Triangles triangles;
};
Surface random_surface(std::uint32_t n, Random& random, bool soup) {
  Vertices samples;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) samples.emplace_back(i, j, random.real(0, 1));
  }
  Surface surface;
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      surface.triangles.push_back({a, a + 1, a + n + 2});
      surface.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  surface.vertices = samples;
  if (!soup) return surface;
  surface.vertices.clear();
  for (auto& triangle : surface.triangles) {
    for (std::uint32_t& corner : triangle) {
      surface.vertices.push_back(samples[corner]);
      corner = static_cast<std::uint32_t>(surface.vertices.size() - 1);
    }
  }
  return surface;
}

// Repeats vertices for each triangle, as some file formats do.
TEST(TriangleMesh, RepeatedVerticesGiveTheSameNeighbours) {
  Random shared(2);
  Random repeated(2);
  const Surface surface = random_surface(9, shared, false);
  const Surface soup = random_surface(9, repeated, true);
  const TriangleMesh expected = mesh_of(surface.vertices, surface.triangles);
  const TriangleMesh found = mesh_of(soup.vertices, soup.triangles);
  EXPECT_EQ(found.neighbours, expected.neighbours);
  EXPECT_EQ(found.convex_edges, expected.convex_edges);
}

// Two cubes that touch along an edge, each with vertices of its own, stay two closed surfaces.
TEST(TriangleMesh, TouchingSurfacesKeepTheirOwnNeighbours) {
  Vertices vertices = cube_vertices;
  Triangles triangles = cube_triangles;
  for (const Vector3& vertex : cube_vertices) vertices.emplace_back(vertex + Vector3(1, 1, 0));
  for (const auto& corners : cube_triangles) triangles.push_back({corners[0] + 8, corners[1] + 8, corners[2] + 8});
  const TriangleMesh mesh = mesh_of(vertices, triangles);
  const TriangleMesh cube = mesh_of(cube_vertices, cube_triangles);
  EXPECT_TRUE(mesh.closed);
  for (std::size_t t = 0; t < 12; ++t) {
    EXPECT_EQ(mesh.neighbours[t], cube.neighbours[t]);
    EXPECT_EQ(mesh.convex_edges[t + 12], cube.convex_edges[t]);
  }
}

TEST(TriangleTree, QueriesMatchBruteForce) {
  Random random(3);
  for (const std::uint32_t count : {1u, 2u, 3u, 10u, 1000u}) {
    std::vector<Aabb> boxes;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vector3 lower = random.vector(10);
      boxes.push_back(Aabb::around(lower, lower + Vector3(random.real(0, 2), random.real(0, 2), 0)));
    }
    TriangleTree tree;
    tree.build(boxes);
    for (int trial = 0; trial < 300; ++trial) {
      const Vector3 lower = random.vector(12);
      const Aabb box = Aabb::around(lower, lower + random.vector(3).cwiseAbs());
      std::vector<std::uint32_t> found, expected;
      tree.query(box, [&](std::uint32_t item) { found.push_back(item); });
      for (std::uint32_t i = 0; i < count; ++i) {
        if (boxes[i].overlaps(box)) expected.push_back(i);
      }
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, expected);
    }
  }
}

std::vector<std::uint32_t> found_in(const TriangleTree& tree, const Aabb& box) {
  std::vector<std::uint32_t> found;
  tree.query(box, [&](std::uint32_t item) { found.push_back(item); });
  return found;
}

// Steps of a node of thin boxes are denormal, and those of one that spans the range of float overflow.
TEST(TriangleTree, IsExactForBoxesOfAllSizes) {
  constexpr float max = std::numeric_limits<float>::max();
  std::vector<Aabb> boxes = {{{-max, -max, -max}, {max, max, max}}, {{0, 0, 0}, {0, 0, 0}}};
  for (int i = -140; i < 120; ++i) {
    const float size = std::ldexp(1.0f, i);
    boxes.push_back({{-size, size, -size}, {size, size, 2 * size}});
    boxes.push_back({{size, -size, size}, {size, -size, size}});
  }
  TriangleTree tree;
  tree.build(boxes);
  for (const Aabb& box : boxes) {
    std::vector<std::uint32_t> found = found_in(tree, box), expected;
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      if (boxes[i].overlaps(box)) expected.push_back(i);
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

TEST(TriangleMesh, RefusesWhatIsNoSurface) {
  const Vertices quad = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  expect_problem(quad, {}, "found no triangle");
  expect_problem(quad, {{0, 1, 2}, {0, 2, 5}}, "found vertex 5 in triangle 1, expected a number below 5");
  expect_problem(quad, {{0, 1, 2}, {0, 3, 3}}, "found no area in triangle 1 (vertices 0, 3, 3)");
  expect_problem({{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}, {{0, 1, 2}}, "found no area in triangle 0 (vertices 0, 1, 2)");
  expect_problem(quad, {{0, 1, 2}, {2, 0, 3}, {2, 0, 4}},
                 "found the edge between vertices 0 and 2 in triangles 0, 1 and 2");
  expect_problem(quad, {{0, 1, 2}, {0, 1, 3}}, "found triangles 0 and 1 that both run from vertex 0 to vertex 1");
  const double infinity = std::numeric_limits<double>::infinity();
  expect_problem({{0, 0, 0}, {1, 0, 0}, {0, infinity, 0}}, {{0, 1, 2}}, "found vertex 2 at (0, inf, 0)");
}

// A cube has its corners' normals along the diagonals, or those of its faces where its edges count as creases.
TEST(TriangleMesh, CornerNormalsAreOfWhatIsAroundUpToCreases) {
  const auto cube = [](double angle) {
    return std::get<TriangleMesh>(build_triangle_mesh(cube_vertices, cube_triangles, angle));
  };
  EXPECT_TRUE(cube(0).corner_normals.empty());
  const TriangleMesh creased = cube(1.5), smooth = cube(1.6);
  EXPECT_NE(creased.content, smooth.content);
  for (std::size_t t = 0; t < cube_triangles.size(); ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      EXPECT_LT((creased.corner_normals[t][corner] - creased.normals[t]).norm(), 1e-12);
      const Vector3 out = (cube_vertices[cube_triangles[t][corner]] - Vector3::Constant(0.5)).normalized();
      EXPECT_LT((smooth.corner_normals[t][corner] - out).norm(), 1e-12);
    }
  }
}

TEST(TriangleMesh, RefusesAnAngleThatIsNone) {
  for (const double angle : {-0.1, 3.2, std::numeric_limits<double>::quiet_NaN()}) {
    const auto result = build_triangle_mesh(cube_vertices, cube_triangles, angle);
    const std::string* problem = std::get_if<std::string>(&result);
    ASSERT_NE(problem, nullptr) << angle;
    EXPECT_NE(problem->find("expected one in [0, pi) rad"), std::string::npos) << *problem;
  }
}

}  // namespace
}  // namespace atl::collision
