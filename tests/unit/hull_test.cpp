// Hulls against the clouds they are made of: nothing outside, no vertex lost, faces and edges that close up.

#include <collision/shapes/hull.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;
using Cloud = std::vector<Vector3>;

Hull hull_of(const Cloud& cloud) {
  auto result = build_hull(cloud);
  const std::string* problem = std::get_if<std::string>(&result);
  EXPECT_EQ(problem, nullptr) << *problem;
  return problem == nullptr ? std::get<Hull>(std::move(result)) : Hull{};
}

void expect_problem(const Cloud& cloud, const std::string& words) {
  const auto result = build_hull(cloud);
  const std::string* problem = std::get_if<std::string>(&result);
  ASSERT_NE(problem, nullptr) << "expected a problem: " << words;
  EXPECT_NE(problem->find(words), std::string::npos) << *problem;
}

Cloud box_corners(const Vector3& half) {
  Cloud corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back(i & 1 ? -half.x() : half.x(), i & 2 ? -half.y() : half.y(), i & 4 ? -half.z() : half.z());
  }
  return corners;
}

Cloud on_sphere(int count, Random& random) {
  Cloud points;
  for (int i = 0; i < count; ++i) points.push_back(random.direction());
  return points;
}

double extent_of(const Cloud& cloud) {
  Vector3 lower = cloud[0], upper = cloud[0];
  for (const Vector3& p : cloud) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  return (upper - lower).maxCoeff();
}

// The place of vertex v in face f, or -1.
int place_in_face(const Hull& hull, std::size_t f, std::size_t v) {
  for (int i = hull.face_start[f]; i < hull.face_start[f + 1]; ++i) {
    if (hull.face_vertices[static_cast<std::size_t>(i)] == v) return i;
  }
  return -1;
}

std::size_t after(const Hull& hull, std::size_t f, int place) {
  const int next = place + 1 == hull.face_start[f + 1] ? hull.face_start[f] : place + 1;
  return hull.face_vertices[static_cast<std::size_t>(next)];
}

void expect_edges_close_up(const Hull& hull) {
  EXPECT_EQ(hull.vertices.size() + hull.face_count(), hull.edges.size() + 2);
  EXPECT_EQ(hull.face_vertices.size(), 2 * hull.edges.size());
  for (std::size_t e = 0; e < hull.edges.size(); ++e) {
    const Hull::Edge& edge = hull.edges[e];
    const int left = place_in_face(hull, edge.left, edge.tail);
    const int right = place_in_face(hull, edge.right, edge.head);
    ASSERT_GE(left, 0);
    ASSERT_GE(right, 0);
    EXPECT_EQ(after(hull, edge.left, left), edge.head);
    EXPECT_EQ(after(hull, edge.right, right), edge.tail);
    EXPECT_EQ(hull.face_edges[static_cast<std::size_t>(left)], e);
    EXPECT_EQ(hull.face_edges[static_cast<std::size_t>(right)], e);
  }
}

// Around each vertex, from outside counter-clockwise, the face on the left of an edge that goes out is on the
// right of the next one.
void expect_cycles_around_vertices(const Hull& hull) {
  ASSERT_EQ(hull.vertex_start.size(), hull.vertices.size() + 1);
  EXPECT_EQ(hull.vertex_edges.size(), 2 * hull.edges.size());
  for (std::size_t v = 0; v < hull.vertices.size(); ++v) {
    const std::size_t begin = hull.vertex_start[v];
    const std::size_t count = hull.vertex_start[v + 1] - begin;
    ASSERT_GE(count, 3u);
    for (std::size_t i = 0; i < count; ++i) {
      const Hull::Edge& edge = hull.edges[hull.vertex_edges[begin + i]];
      const Hull::Edge& next = hull.edges[hull.vertex_edges[begin + (i + 1) % count]];
      ASSERT_TRUE(edge.tail == v || edge.head == v);
      EXPECT_EQ(edge.tail == v ? edge.left : edge.right, next.tail == v ? next.right : next.left);
    }
  }
}

void expect_faces_are_flat_and_convex(const Hull& hull, double tolerance) {
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const Hull::Plane& plane = hull.planes[f];
    EXPECT_NEAR(plane.normal.norm(), 1, 1e-12);
    ASSERT_GE(hull.face_start[f + 1] - hull.face_start[f], 3);
    for (int i = hull.face_start[f]; i < hull.face_start[f + 1]; ++i) {
      const std::size_t a = hull.face_vertices[static_cast<std::size_t>(i)];
      const std::size_t b = after(hull, f, i);
      const std::size_t c = after(hull, f, place_in_face(hull, f, b));
      EXPECT_NEAR(plane.normal.dot(hull.vertices[a]), plane.offset, tolerance);
      const Vector3 side = hull.vertices[b] - hull.vertices[a];
      const Vector3 turn = side.cross(hull.vertices[c] - hull.vertices[b]);
      EXPECT_GT(turn.dot(plane.normal), -tolerance * side.norm());
    }
  }
}

// `tolerance` as part of the extent.
void expect_hull(const Hull& hull, const Cloud& cloud, double tolerance = 1e-12) {
  expect_edges_close_up(hull);
  expect_cycles_around_vertices(hull);
  const double distance = tolerance * extent_of(cloud);
  expect_faces_are_flat_and_convex(hull, distance);
  for (const Hull::Plane& plane : hull.planes) {
    for (const Vector3& point : cloud) ASSERT_LE(plane.normal.dot(point) - plane.offset, distance);
  }
  // Vertices are points of the cloud, in its order.
  auto from = cloud.begin();
  for (const Vector3& vertex : hull.vertices) {
    from = std::find(from, cloud.end(), vertex);
    ASSERT_NE(from, cloud.end());
    ++from;
  }
}

TEST(Hull, OfABoxIsTheBox) {
  const Vector3 half(0.3, 2, 0.7);
  const Cloud corners = box_corners(half);
  const Hull hull = hull_of(corners);
  expect_hull(hull, corners);
  const Hull box = box_hull(half);
  expect_hull(box, corners);
  EXPECT_EQ(hull.vertices, box.vertices);
  EXPECT_EQ(hull.face_vertices, box.face_vertices);
  EXPECT_EQ(hull.face_start, box.face_start);
  EXPECT_EQ(hull.vertex_edges, box.vertex_edges);
  ASSERT_EQ(box.face_count(), 6u);
  EXPECT_EQ(box.edges.size(), 12u);
  for (const Hull::Plane& plane : box.planes) {
    EXPECT_EQ(plane.normal.cwiseAbs().maxCoeff(), 1);  // exactly along an axis
    EXPECT_DOUBLE_EQ(plane.offset, plane.normal.cwiseAbs().dot(half));
  }
  EXPECT_DOUBLE_EQ(box.inner_radius, 0.3);
  EXPECT_DOUBLE_EQ(box.bounding_radius, half.norm());
  EXPECT_EQ(box.lower, -half);
  EXPECT_EQ(box.upper, half);
  EXPECT_FALSE(box.simplified);
}

// Points inside, on faces and on edges, and repeated ones, are no vertices.
TEST(Hull, DropsPointsThatAreNoCorners) {
  Cloud grid;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) {
      for (int k = 0; k <= 4; ++k) grid.emplace_back(0.5 * i, 0.25 * j, 0.75 * k);
    }
  }
  grid.insert(grid.end(), grid.begin(), grid.end());
  const Hull hull = hull_of(grid);
  expect_hull(hull, grid);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_EQ(hull.face_count(), 6u);
}

// Coplanar faces are one in any orientation, size and place, also where the points are only floats.
TEST(Hull, MergesCoplanarFacesWhateverTheRounding) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const double size = random.magnitude(1e-4, 1e4);
    const Matrix3 turn = random.rotation().toRotationMatrix();
    const Vector3 place = random.vector(2 * size);
    const double sides = 3 + random.below(20);
    Cloud prism;
    for (double i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      for (const double z : {-0.7, 0.7}) {
        const Vector3 corner = place + turn * Vector3(std::cos(angle), std::sin(angle), z) * size;
        prism.push_back(trial % 2 == 0 ? corner : Vector3(corner.cast<float>().cast<double>()));
      }
    }
    const Hull hull = hull_of(prism);
    expect_hull(hull, prism, 1e-6);
    EXPECT_EQ(hull.vertices.size(), 2 * sides);
    EXPECT_EQ(hull.face_count(), 2 + sides);
  }
}

TEST(Hull, KeepsEveryVertexOfPointsOnASphere) {
  Random random(2);
  for (const int count : {4, 5, 8, 20, 100, 255}) {
    const Cloud cloud = on_sphere(count, random);
    const Hull hull = hull_of(cloud);
    expect_hull(hull, cloud);
    EXPECT_EQ(hull.vertices, cloud);
    EXPECT_EQ(hull.face_count(), 2 * cloud.size() - 4);
    EXPECT_FALSE(hull.simplified);
  }
}

// Clouds on a coarse lattice have many points that are coplanar and collinear, here exactly or nearly so.
TEST(Hull, NearlyDegenerateCloudsGiveValidHulls) {
  Random random(3);
  int hulls = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const double noise = std::pow(10.0, -1.0 - random.below(17));
    const std::uint32_t count = 4 + random.below(60);
    Cloud cloud;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vector3 node(random.below(4), random.below(4), random.below(4));
      cloud.push_back(node + random.vector(noise));
    }
    const auto result = build_hull(cloud);
    const Hull* hull = std::get_if<Hull>(&result);
    if (hull == nullptr) {  // a few are flat
      EXPECT_NE(std::get<std::string>(result).find("plane"), std::string::npos) << std::get<std::string>(result);
      continue;
    }
    ++hulls;
    expect_hull(*hull, cloud, 2e-6);
  }
  EXPECT_GT(hulls, 950);
}

TEST(Hull, MoreThan255VerticesAreSimplified) {
  Random random(4);
  const Cloud cloud = on_sphere(4000, random);
  const Hull hull = hull_of(cloud);
  EXPECT_TRUE(hull.simplified);
  EXPECT_EQ(hull.vertices.size(), Hull::max_vertices);
  expect_edges_close_up(hull);
  expect_cycles_around_vertices(hull);
  expect_faces_are_flat_and_convex(hull, 1e-12);
  // The best polytope with 255 vertices has 2.5 % less volume than the sphere (Gruber 1993: 5.8 / 255 of it).
  EXPECT_GT(hull.mass.volume, 0.96 * 4 / 3 * std::numbers::pi);
  for (const Hull::Plane& plane : hull.planes) {
    for (const Vector3& point : cloud) ASSERT_LT(plane.normal.dot(point) - plane.offset, 0.05);
  }
}

TEST(Hull, RefusesWhatHasNone) {
  expect_problem({}, "found 0 distinct points, expected at least 4");
  expect_problem({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, "found 3 distinct points");
  expect_problem(Cloud(10, Vector3(1, 2, 3)), "found 1 distinct points");
  expect_problem({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 0, 0}}, "plane");
  expect_problem({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.3, 0.4, 1e-8}}, "plane");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_problem({{0, 0, 0}, {1, 0, 0}, {0, nan, 0}, {0, 0, 1}}, "found point 2 at (0, nan, 0), expected finite");
  expect_problem({{0, 0, 0}, {1e200, 0, 0}, {0, 1e200, 0}, {0, 0, 1e200}}, "1e30");
}

}  // namespace
}  // namespace atl::collision
