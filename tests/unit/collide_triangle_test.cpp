// Solids on one triangle: its edges as far as neighbours leave room, and never its back.

#include <collision/narrowphase/distance.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

// A triangle in the x-y plane, whose neighbours bend down by an angle (rad) from it; 0 is flat.
Triangle bent_triangle(double angle) {
  Triangle triangle;
  triangle.vertices = {Vector3(-2, -1, 0), Vector3(2, -1, 0), Vector3(0, 2, 0)};
  triangle.normal = Vector3::UnitZ();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 edge = (triangle.vertices[(i + 1) % 3] - triangle.vertices[i]).normalized();
    const Vector3 outward = edge.cross(triangle.normal);
    triangle.neighbour_normals[i] = std::cos(angle) * triangle.normal + std::sin(angle) * outward;
    if (is_convex_edge(triangle.normal, triangle.neighbour_normals[i], edge)) {
      triangle.convex_edges = static_cast<std::uint8_t>(triangle.convex_edges | 1u << i);
    }
  }
  return triangle;
}

Triangle lone_triangle() {
  Triangle triangle = bent_triangle(0);
  triangle.neighbour_normals.fill(triangle.normal);
  triangle.convex_edges = 7;
  return triangle;
}

Manifold touch(const Shape& solid, const Triangle& triangle, const Pose& pose, double margin) {
  Manifold manifold;
  collide_triangle(solid, triangle, 12345, pose, margin, manifold);
  return manifold;
}

double lowest(const Shape& solid, const Pose& pose, const Vector3& direction) {
  const Vector3 local = pose.orientation.conjugate() * Vector3(-direction);
  return direction.dot(pose.position) - reach_along(solid, local);
}

Hull random_hull(std::uint32_t seed, int count) {
  Random random(seed);
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) points.push_back(0.4 * random.direction());
  return std::get<Hull>(build_hull(points));
}

struct SolidsOfEachKind {
  Hull hull = random_hull(7, 30);
  std::vector<Shape> shapes = {Shape::sphere(0.3),         Shape::capsule(0.15, 0.25), Shape::box({0.3, 0.2, 0.25}),
                               Shape::cylinder(0.25, 0.2), Shape::cone(0.25, 0.3),     Shape::convex_hull(hull)};
};

// At an edge whose neighbour bends down by 60 degrees, the normal turns with the sphere, and no farther.
TEST(SphereOnTriangle, AroundAConvexEdgeTheNormalFollowsTheCentreUpToTheNeighbours) {
  const Shape sphere = Shape::sphere(0.3);
  const Triangle triangle = bent_triangle(3.14159265358979 / 3);
  for (int i = -20; i <= 40; ++i) {
    const double angle = i * 0.03 + 0.011;
    // About the edge from vertex 0 to 1, which looks along -y.
    const Vector3 direction(0, -std::sin(angle), std::cos(angle));
    const Manifold manifold = touch(sphere, triangle, {Vector3(0.2, -1, 0) + 0.29 * direction, {1, 0, 0, 0}}, 0.01);
    if (angle > 3.14159265358979 / 3) {
      EXPECT_EQ(manifold.count, 0) << "the neighbour's: " << angle;
      continue;
    }
    if (angle < 0) {
      // Over the face: on its plane, however near the edge.
      const bool is_near = 0.29 * direction.z() - 0.3 <= 0.01;
      ASSERT_EQ(manifold.count, is_near) << angle;
      EXPECT_LT((manifold.normal - Vector3::UnitZ()).norm(), 1e-12);
      continue;
    }
    ASSERT_EQ(manifold.count, 1) << angle;
    EXPECT_LT((manifold.normal - direction).norm(), 1e-9) << angle;
    EXPECT_NEAR(manifold.points[0].separation, -0.01, 1e-12) << angle;
  }
}

// Beside a triangle whose neighbours carry on flat or rise, everything is theirs.
TEST(Triangle, BesideAnEdgeThatIsNotConvexNothingIsTouched) {
  const SolidsOfEachKind solids;
  Random random(2);
  for (const double bend : {0.0, -0.5}) {
    const Triangle triangle = bent_triangle(bend);
    for (int i = 0; i < 300; ++i) {
      const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
      Pose pose{{random.real(-1, 1), 0, random.real(-0.1, 0.1)}, random.rotation()};
      pose.position.y() = -1 - 1e-4 + lowest(solid, {Vector3::Zero(), pose.orientation}, -Vector3::UnitY());
      ASSERT_NEAR(lowest(solid, pose, -Vector3::UnitY()), 1 + 1e-4, 1e-9);
      EXPECT_EQ(touch(solid, triangle, pose, 0.2).count, 0) << i % 6;
    }
  }
}

TEST(Triangle, NothingBehindIsTouched) {
  const SolidsOfEachKind solids;
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Triangle triangle = i % 2 == 0 ? lone_triangle() : bent_triangle(random.real(-1.5, 1.5));
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    Pose pose{{random.real(-2, 2), random.real(-1, 2), 0}, random.rotation()};
    pose.position.z() = -1e-6 + lowest(solid, {Vector3::Zero(), pose.orientation}, -Vector3::UnitZ());
    EXPECT_EQ(touch(solid, triangle, pose, 0.2).count, 0);
  }
}

// Apart from a triangle without neighbours, the separation is the distance wherever the nearest point can be
// touched, and never more than the distance.
TEST(LoneTriangle, SeparationIsTheDistance) {
  const SolidsOfEachKind solids;
  const Triangle triangle = lone_triangle();
  Random random(5);
  int at_vertex_or_edge = 0;
  int at_face = 0;
  for (int i = 0; i < 6000; ++i) {
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    const Pose pose{{random.real(-2.5, 2.5), random.real(-1.5, 2.5), random.real(0, 0.6)}, random.rotation()};
    std::array<Vector3, 3> seen;
    for (std::size_t v = 0; v < 3; ++v) {
      seen[v] = pose.orientation.conjugate() * (triangle.vertices[v] - pose.position);
    }
    const ClosestPoints closest = closest_points(solid, seen);
    if (closest.distance < 1e-6) continue;
    const Vector3 normal = -(pose.orientation * closest.normal);
    const Manifold manifold = touch(solid, triangle, pose, 0.1);
    if (closest.distance > 0.1 + 1e-9) {
      EXPECT_EQ(manifold.count, 0) << i;
      continue;
    }
    if (normal.z() < 1e-6) continue;  // from below the plane
    ASSERT_GT(manifold.count, 0) << i << " solid " << i % 6 << " normal " << normal.transpose();
    (normal.z() > 1 - 1e-9 ? at_face : at_vertex_or_edge) += 1;
    // Within 8 degrees, a face may stand in, up to 2% of the size.
    EXPECT_NEAR(manifold.least_separation(), closest.distance, 0.02 * solid.inner_radius + 1e-6)
        << i << " solid " << i % 6;
    if (normal.z() < 0.98) {
      EXPECT_LT((manifold.normal - normal).norm(), 1e-3) << i << " solid " << i % 6;
    }
  }
  EXPECT_GT(at_face, 200);
  EXPECT_GT(at_vertex_or_edge, 200);
}

// The normal stays in the cone between the triangle's and the neighbours', and is a unit vector.
TEST(Triangle, NormalsStayWithinTheNeighbours) {
  const SolidsOfEachKind solids;
  Random random(6);
  int touching = 0;
  for (int i = 0; i < 6000; ++i) {
    const double bend = random.real(0, 1.4);
    const Triangle triangle = bent_triangle(bend);
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    const Pose pose{{random.real(-2.3, 2.3), random.real(-1.3, 2.3), random.real(-0.3, 0.4)}, random.rotation()};
    const Manifold manifold = touch(solid, triangle, pose, 0.05);
    std::set<FeatureId> ids;
    for (int k = 0; k < manifold.count; ++k) {
      const Manifold::Point& point = manifold.points[static_cast<std::size_t>(k)];
      EXPECT_TRUE(ids.insert(point.id).second);
      EXPECT_EQ(point.id >> 28 & 0xfffffff, 12345u);
      EXPECT_LE(point.separation, 0.05 + 1e-9);
      EXPECT_LT((point.position - pose.position).norm(), 1.03 * solid.bounding_radius);
    }
    if (manifold.count == 0) continue;
    ++touching;
    EXPECT_NEAR(manifold.normal.norm(), 1, 1e-12);
    // The normals of three neighbours that bend alike are the corners of a cone about z; towards a vertex it
    // reaches farther.
    double ahead = 0;
    for (std::size_t e = 0; e < 3; ++e) {
      const Vector3 edge = (triangle.vertices[(e + 1) % 3] - triangle.vertices[e]).normalized();
      ahead = std::max(ahead, manifold.normal.dot(edge.cross(triangle.neighbour_normals[e])));
    }
    EXPECT_LT(ahead, 1e-6);
  }
  EXPECT_GT(touching, 1000);
}

}  // namespace
}  // namespace atl::collision
