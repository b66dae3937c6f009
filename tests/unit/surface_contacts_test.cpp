// Solids on meshes and height fields: a flat one is a half-space, a bent one has the normals of its parts.

#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/distance.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "grid_mesh.h"
#include "support/random.h"

namespace atl::collision {
namespace {

using test::grid;
using test::Random;

double flat(double, double) { return 0; }

TriangleMesh box_mesh(const Vector3& half) {
  std::vector<Vector3> vertices;
  for (int i = 0; i < 8; ++i) {
    vertices.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z());
  }
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                                               {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                                               {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles));
}

Quaternion turned(double angle, const Vector3& axis) {
  const Vector3 v = std::sin(0.5 * angle) * axis;
  return {std::cos(0.5 * angle), v.x(), v.y(), v.z()};
}

SurfaceManifolds touch(const Shape& solid, const Shape& surface, const Pose& pose, double margin) {
  SurfaceManifolds result;
  collide_surface(solid, surface, pose, margin, result);
  return result;
}

Hull random_hull(std::uint32_t seed) {
  Random random(seed);
  std::vector<Vector3> points;
  for (int i = 0; i < 24; ++i) points.push_back(0.5 * random.direction());
  return std::get<Hull>(build_hull(points));
}

struct Solids {
  Hull hull = random_hull(5);
  std::vector<Shape> shapes = {Shape::sphere(0.4),        Shape::capsule(0.2, 0.4), Shape::box({0.5, 0.3, 0.4}),
                               Shape::cylinder(0.4, 0.3), Shape::cone(0.4, 0.4),    Shape::convex_hull(hull)};
};

double lowest(const Shape& solid, const Pose& pose) {
  const Vector3 down = pose.orientation.conjugate() * Vector3(-Vector3::UnitZ());
  return pose.position.z() - reach_along(solid, down);
}

void expect_sound(const Shape& solid, const Pose& pose, const SurfaceManifolds& found) {
  std::set<std::pair<int, FeatureId>> ids;
  for (int m = 0; m < found.count; ++m) {
    const Manifold& manifold = found.manifolds[static_cast<std::size_t>(m)];
    EXPECT_GT(manifold.count, 0);
    EXPECT_TRUE(manifold.reference_is_second);
    EXPECT_NEAR(manifold.normal.norm(), 1, 1e-9);
    for (int i = 0; i < manifold.count; ++i) {
      const Manifold::Point& point = manifold.points[static_cast<std::size_t>(i)];
      EXPECT_TRUE(ids.emplace(m, point.id).second) << "two points with one id";
      EXPECT_TRUE(point.position.allFinite());
      EXPECT_TRUE(std::isfinite(point.separation));
      // A disc's face is a polygon around it, up to 2% larger, and may be tilted.
      EXPECT_LT((point.position - pose.position).norm(), solid.bounding_radius * 1.03);
    }
  }
}

// Whatever the solid, and however the triangles lie under it.
TEST(FlatMesh, IsAHalfSpaceForEverySolid) {
  const Solids solids;
  for (const int cells : {2, 7, 40}) {
    const TriangleMesh mesh = grid(cells, 3, flat);
    const Shape surface = Shape::triangle_mesh(mesh);
    const Shape plane = Shape::half_space(Vector3::UnitZ(), 0);
    Random random(1);
    for (int i = 0; i < 600; ++i) {
      const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
      Pose pose{{random.real(-2, 2), random.real(-2, 2), 0}, random.rotation()};
      const double separation = random.real(-0.1, 0.015);
      pose.position.z() = separation - lowest(solid, pose);
      const SurfaceManifolds found = touch(solid, surface, pose, 0.02);
      ASSERT_EQ(found.count, 1) << "solid " << i % 6 << ", cells " << cells;
      const Manifold& manifold = found.manifolds[0];
      EXPECT_LT((manifold.normal - Vector3::UnitZ()).norm(), 1e-12);
      EXPECT_NEAR(manifold.min_separation(), separation, 1e-9) << "solid " << i % 6 << ", cells " << cells;
      Manifold expected;
      collide_half_space(solid, plane, relative(pose, {Vector3::Zero(), Quaternion::Identity()}), 0.02, expected);
      EXPECT_EQ(manifold.count, expected.count) << "solid " << i % 6 << ", cells " << cells;
      for (int k = 0; k < manifold.count; ++k) {
        const Manifold::Point& point = manifold.points[static_cast<std::size_t>(k)];
        EXPECT_NEAR(point.separation, point.position.z(), 1e-12);
      }
      expect_sound(solid, pose, found);
    }
  }
}

// Corners right on the lines and vertices of the grid belong to several triangles, and count once.
TEST(FlatMesh, HoldsABoxWhoseCornersAreVerticesOfTheMesh) {
  const TriangleMesh mesh = grid(16, 2, flat);
  const Shape box = Shape::box({0.5, 0.25, 0.4});
  for (int i = -4; i <= 4; ++i) {
    for (const double aside : {0.0, 1e-7, -1e-7, 1e-9, 0.1}) {
      const Pose pose{{0.25 * i + aside, 0.25 * i, 0.4}, {1, 0, 0, 0}};
      const SurfaceManifolds found = touch(box, Shape::triangle_mesh(mesh), pose, 0.01);
      ASSERT_EQ(found.count, 1);
      ASSERT_EQ(found.manifolds[0].count, 4);
      for (const Manifold::Point& point : found.manifolds[0].points) {
        EXPECT_LT(((point.position - pose.position).cwiseAbs() - Vector3(0.5, 0.25, 0.4)).norm(), 1e-9);
      }
    }
  }
}

// Ids of corners don't depend on the triangle below: what carried before the box moved on still does.
TEST(FlatMesh, KeepsTheIdsOfABoxThatSlides) {
  const TriangleMesh mesh = grid(20, 2, flat);
  const Shape box = Shape::box({0.5, 0.3, 0.4});
  std::set<FeatureId> first;
  for (int i = 0; i < 100; ++i) {
    const Pose pose{{-0.8 + 0.016 * i, 0.3 - 0.007 * i, 0.4}, turned(0.2, Vector3::UnitZ())};
    const SurfaceManifolds found = touch(box, Shape::triangle_mesh(mesh), pose, 0.01);
    ASSERT_EQ(found.count, 1);
    std::set<FeatureId> ids;
    for (int k = 0; k < found.manifolds[0].count; ++k) {
      ids.insert(found.manifolds[0].points[static_cast<std::size_t>(k)].id);
    }
    if (i == 0) first = ids;
    EXPECT_EQ(ids, first);
  }
}

TEST(FlatField, IsTheSameAsAMesh) {
  const HeightField field =
      std::get<HeightField>(build_height_field(21, 21, 0.2, 0.2, std::vector<double>(21 * 21, 0.0)));
  const Solids solids;
  Random random(4);
  for (int i = 0; i < 600; ++i) {
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    Pose pose{{random.real(1, 3), random.real(1, 3), 0}, random.rotation()};
    pose.position.z() = random.real(-0.1, 0.015) - lowest(solid, pose);
    const SurfaceManifolds found = touch(solid, Shape::height_field(field), pose, 0.02);
    ASSERT_EQ(found.count, 1);
    EXPECT_NEAR(found.manifolds[0].min_separation(), lowest(solid, pose), 1e-9);
  }
}

// A box mesh is a box: its edges and corners push as those of the exact rounded shape.
TEST(ConvexMesh, PushesASphereAwayFromItsNearestPoint) {
  const Vector3 half(1, 0.8, 0.6);
  const TriangleMesh mesh = box_mesh(half);
  const Shape sphere = Shape::sphere(0.3);
  Random random(6);
  int touching = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3 at = random.vector(1.3);
    const Vector3 nearest = at.cwiseMax(-half).cwiseMin(half);
    const double distance = (at - nearest).norm();
    if (distance < 1e-3) continue;
    const SurfaceManifolds found = touch(sphere, Shape::triangle_mesh(mesh), {at, random.rotation()}, 0.1);
    if (distance > 0.4 + 1e-9) {
      EXPECT_EQ(found.count, 0) << at.transpose();
      continue;
    }
    ++touching;
    ASSERT_EQ(found.count, 1) << at.transpose();
    const Manifold& manifold = found.manifolds[0];
    ASSERT_EQ(manifold.count, 1) << at.transpose();
    EXPECT_LT((manifold.normal - (at - nearest) / distance).norm(), 1e-6) << at.transpose();
    EXPECT_NEAR(manifold.points[0].separation, distance - 0.3, 1e-9) << at.transpose();
  }
  EXPECT_GT(touching, 1000);
}

// One that has no neighbours can be touched at all its edges and corners, from the front.
TriangleMesh lone_triangle() {
  const std::vector<Vector3> vertices = {{-2, -1, 0}, {2, -1, 0}, {0, 2, 0}};
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}};
  return std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles));
}

// Apart from it, the separation is the distance wherever the nearest point can be touched, and never more.
TEST(LoneTriangle, SeparationIsTheDistance) {
  const Solids solids;
  const TriangleMesh mesh = lone_triangle();
  Random random(5);
  int at_vertex_or_edge = 0;
  int at_face = 0;
  for (int i = 0; i < 6000; ++i) {
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    const Pose pose{{random.real(-2.5, 2.5), random.real(-1.5, 2.5), random.real(0, 0.6)}, random.rotation()};
    std::array<Vector3, 3> seen;
    for (std::size_t v = 0; v < 3; ++v) seen[v] = pose.orientation.conjugate() * (mesh.vertices[v] - pose.position);
    const ClosestPoints closest = closest_points(solid, seen);
    if (closest.distance < 1e-6) continue;
    const Vector3 normal = -(pose.orientation * closest.normal);
    const SurfaceManifolds found = touch(solid, Shape::triangle_mesh(mesh), pose, 0.1);
    if (closest.distance > 0.1 + 1e-9) {
      EXPECT_EQ(found.count, 0) << i;
      continue;
    }
    if (normal.z() < 1e-6) continue;  // from below the plane
    ASSERT_EQ(found.count, 1) << i << " solid " << i % 6 << " normal " << normal.transpose();
    const Manifold& manifold = found.manifolds[0];
    (normal.z() > 1 - 1e-9 ? at_face : at_vertex_or_edge) += 1;
    // Within 8 degrees, a face may stand in, up to 2% of the size.
    EXPECT_NEAR(manifold.min_separation(), closest.distance, 0.02 * solid.inner_radius + 1e-6)
        << i << " solid " << i % 6;
    if (normal.z() < 0.98) {
      EXPECT_LT((manifold.normal - normal).norm(), 1e-3) << i << " solid " << i % 6;
    }
  }
  EXPECT_GT(at_face, 200);
  EXPECT_GT(at_vertex_or_edge, 200);
}

TEST(LoneTriangle, NothingBehindIsTouched) {
  const Solids solids;
  const TriangleMesh mesh = lone_triangle();
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    Pose pose{{random.real(-2, 2), random.real(-1, 2), 0}, random.rotation()};
    pose.position.z() = -1e-6 - reach_along(solid, pose.orientation.conjugate() * Vector3::UnitZ());
    EXPECT_EQ(touch(solid, Shape::triangle_mesh(mesh), pose, 0.2).count, 0);
  }
}

// Apart from a box mesh, every solid's separation is its distance from the box; where it sinks in a little, that along
// the best axis that the audit of two solids finds.
TEST(ConvexMesh, SeparationIsTheDistanceFromTheSolidItBounds) {
  const Vector3 half(1, 0.8, 0.6);
  const TriangleMesh mesh = box_mesh(half);
  const Shape box = Shape::box(half);
  const Solids solids;
  Random random(10);
  int apart = 0;
  int shallow = 0;
  for (int i = 0; i < 6000; ++i) {
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    const Pose pose{random.vector(1.6), random.rotation()};
    const ClosestPoints closest = closest_points(box, solid, pose);
    const SurfaceManifolds found = touch(solid, Shape::triangle_mesh(mesh), pose, 0.1);
    double min = INFINITY;
    for (int m = 0; m < found.count; ++m) {
      min = std::min(min, found.manifolds[static_cast<std::size_t>(m)].min_separation());
    }
    if (closest.distance > 0.1 + 1e-9) {
      EXPECT_EQ(found.count, 0) << i << " solid " << i % 6;
    } else if (closest.distance > 1e-6) {
      ++apart;
      EXPECT_NEAR(min, closest.distance, 0.02 * solid.inner_radius + 1e-6) << i << " solid " << i % 6;
    } else {
      if (solid.kind == ShapeKind::Sphere) continue;
      Manifold expected;
      expected.axis = 0;
      const Pose from = relative(pose, {Vector3::Zero(), Quaternion::Identity()});
      collide_convex(solid, box, from, 0.1, expected);
      const double depth = -expected.min_separation();
      if (!(depth > 0 && depth < 0.1 * solid.inner_radius)) continue;
      ++shallow;
      EXPECT_NEAR(min, -depth, 0.03 * solid.inner_radius) << i << " solid " << i % 6;
    }
  }
  EXPECT_GT(apart, 500);
  EXPECT_GT(shallow, 100);
}

TEST(ConcaveMesh, CornerOfFloorAndWallsHoldsABoxFromThreeSides) {
  // The inside of a box.
  TriangleMesh outside = box_mesh({2, 2, 2});
  for (auto& triangle : outside.triangles) std::swap(triangle[0], triangle[1]);
  const TriangleMesh mesh = std::get<TriangleMesh>(build_triangle_mesh(outside.vertices, outside.triangles));
  const Shape box = Shape::box({0.5, 0.5, 0.5});
  const SurfaceManifolds found = touch(box, Shape::triangle_mesh(mesh), {{-1.501, -1.502, -1.503}, {1, 0, 0, 0}}, 0.01);
  ASSERT_EQ(found.count, 3);
  for (int i = 0; i < 3; ++i) {
    const Manifold& manifold = found.manifolds[static_cast<std::size_t>(i)];
    EXPECT_EQ(manifold.count, 4);
    EXPECT_NEAR(manifold.min_separation(), -Vector3(0.001, 0.002, 0.003).dot(manifold.normal), 1e-12);
  }
}

TEST(ConvexMesh, BoxOverhangingAnEdgeIsHeldByTheTopAlone) {
  const TriangleMesh mesh = box_mesh({2, 2, 1});
  const Shape box = Shape::box({0.5, 0.4, 0.3});
  Random random(7);
  for (int i = 0; i < 500; ++i) {
    const double yaw = random.real(-4, 4);
    const double depth = random.real(0, 0.005);
    const Pose pose{{2 + random.real(-0.3, 0.1), random.real(-2, 2), 1.3 - depth}, turned(yaw, Vector3::UnitZ())};
    const SurfaceManifolds found = touch(box, Shape::triangle_mesh(mesh), pose, 0.01);
    ASSERT_EQ(found.count, 1) << i;
    EXPECT_LT((found.manifolds[0].normal - Vector3::UnitZ()).norm(), 1e-9) << i;
    EXPECT_NEAR(found.manifolds[0].min_separation(), -depth, 1e-9) << i;
    EXPECT_GE(found.manifolds[0].count, 3) << i;
  }
}

// One that has gone through a slab is still pushed out of the side that its centre is on.
TEST(ConvexMesh, ThinSlabPushesBackWhatPokesThrough) {
  const TriangleMesh mesh = box_mesh({2, 2, 0.05});
  const Solids solids;
  Random random(11);
  for (int i = 0; i < 300; ++i) {
    const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
    Pose pose{{random.real(-1, 1), random.real(-1, 1), 0}, random.rotation()};
    const double depth = random.real(0.101, 0.13);
    pose.position.z() = 0.05 - depth - lowest(solid, pose);
    const SurfaceManifolds found = touch(solid, Shape::triangle_mesh(mesh), pose, 0.02);
    ASSERT_EQ(found.count, 1) << i % 6;
    EXPECT_LT((found.manifolds[0].normal - Vector3::UnitZ()).norm(), 1e-9) << i % 6;
    EXPECT_NEAR(found.manifolds[0].min_separation(), -depth, 1e-9) << i % 6;
  }
}

TEST(ConvexMesh, RidgeCarriesABoxAlongItsLine) {
  const TriangleMesh mesh = grid(8, 2, [](double x, double) { return -std::abs(x); });
  const Shape box = Shape::box({0.5, 0.4, 0.3});
  for (const double yaw : {0.0, 0.3, 1.1, 1.5707963267948966}) {
    const Pose pose{{0.02, 0.1, 0.299}, turned(yaw, Vector3::UnitZ())};
    const SurfaceManifolds found = touch(box, Shape::triangle_mesh(mesh), pose, 0.01);
    ASSERT_EQ(found.count, 1);
    const Manifold& manifold = found.manifolds[0];
    EXPECT_LT((manifold.normal - Vector3::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(manifold.min_separation(), -0.001, 1e-9);
    ASSERT_GE(manifold.count, 2);
    double span = 0;
    for (int i = 0; i < manifold.count; ++i) {
      const Vector3& p = manifold.points[static_cast<std::size_t>(i)].position;
      EXPECT_NEAR(p.x(), 0, 1e-9);
      span = std::max(span, std::abs(p.y() - manifold.points[0].position.y()));
    }
    EXPECT_GT(span, 0.75);
  }
}

// Depths are those of the half-space of the mesh's face, whatever the ratio of sizes.
TEST(FlatMesh, AnyRatioOfSizesWorks) {
  const Solids solids;
  for (const double cell : {0.02, 0.3, 50.0, 1e4}) {
    const TriangleMesh mesh = grid(100, 50 * cell, flat);
    Random random(8);
    for (int i = 0; i < 60; ++i) {
      const Shape& solid = solids.shapes[static_cast<std::size_t>(i % 6)];
      Pose pose{{random.real(-20, 20) * cell, random.real(-20, 20) * cell, 0}, random.rotation()};
      pose.position.z() = -0.01 - lowest(solid, pose);
      const SurfaceManifolds found = touch(solid, Shape::triangle_mesh(mesh), pose, 0.02);
      ASSERT_EQ(found.count, 1) << cell << " " << i % 6;
      EXPECT_NEAR(found.manifolds[0].min_separation(), -0.01, 1e-9) << cell << " " << i % 6;
    }
  }
}

// A ridge that bends by less than counts as an edge: the ball's foot on either side lies beyond it.
TEST(SurfaceContacts, ABallOverAnEdgeThatHardlyBendsTouches) {
  for (const double angle : {1e-5, 3e-4, 9e-4, 2e-3}) {
    const TriangleMesh ridge = grid(2, 1, [&](double x, double) { return -0.5 * angle * std::abs(x); });
    for (const double x : {-2e-4, -1e-5, 0.0, 1e-5, 2e-4}) {
      const SurfaceManifolds found =
          touch(Shape::sphere(0.3), Shape::triangle_mesh(ridge), {{x, 0.4, 0.2999}, Quaternion::Identity()}, 0.01);
      ASSERT_GE(found.count, 1) << angle << ", " << x;
      EXPECT_NEAR(found.manifolds[0].min_separation(), -1e-4, 1e-6) << angle << ", " << x;
    }
  }
}

// Vertices of a sphere from inside, in rings around the lowest.
TriangleMesh bowl(std::uint32_t rings, std::uint32_t sectors, double smooth_angle) {
  std::vector<Vector3> vertices = {{0, 0, 0}};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 1; i <= rings; ++i) {
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const double out = M_PI / 2 * i / rings, around = 2 * M_PI * j / sectors;
      vertices.emplace_back(std::sin(out) * std::cos(around), std::sin(out) * std::sin(around), 1 - std::cos(out));
    }
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i == 0 ? 0 : 1 + (i - 1) * sectors + j % sectors; };
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t j = 0; j < sectors; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      if (i > 0) triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles, smooth_angle));
}

TEST(SmoothSurface, ABallTouchesTheSphereThatTheTrianglesStandFor) {
  const TriangleMesh mesh = bowl(20, 80, 0.3);
  const Shape ball = Shape::sphere(0.1);
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const double out = random.real(0.02, 1.2), around = random.real(0, 6.28), depth = random.real(-1e-3, 1e-3);
    const Vector3 towards(std::sin(out) * std::cos(around), std::sin(out) * std::sin(around), -std::cos(out));
    const Vector3 centre = Vector3::UnitZ() + (0.9 + depth) * towards;
    const SurfaceManifolds found = touch(ball, Shape::triangle_mesh(mesh), {centre, Quaternion::Identity()}, 0.02);
    ASSERT_EQ(found.count, 1);
    EXPECT_LT((found.manifolds[0].normal + towards).norm(), 2e-4);   // facets: 0.04
    EXPECT_NEAR(found.manifolds[0].min_separation(), -depth, 4e-6);  // facets: 8e-4
    EXPECT_EQ(found.manifolds[0].rise, 0);
  }
}

// Two plain facets that meet at x = 0, the second bent up by an angle.
TriangleMesh bent_floor(double bend) {
  const double far = 5 * std::cos(bend), up = 5 * std::sin(bend);
  const std::vector<Vector3> vertices = {{-5, -5, 0}, {0, -5, 0}, {0, 5, 0}, {-5, 5, 0}, {far, -5, up}, {far, 5, up}};
  const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}};
  return std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles, 0));
}

// A ball that comes to a rising facet in the step has the plane of that one as well, before it is over it.
TEST(PlainSurface, ABallMeetsTheFacetsThatItComesToInTheStep) {
  const double radius = 0.1, before = 0.1, way = 0.3;
  for (const double bend : {0.01, 0.1, 0.8, -0.1}) {
    const TriangleMesh mesh = bent_floor(bend);
    const auto touch_in_step = [&](double shift) {
      SurfaceManifolds found;
      collide_surface(Shape::sphere(radius), Shape::triangle_mesh(mesh),
                      {{-before, 0.3, radius}, Quaternion::Identity()}, 0.02, found, {shift, 0, 0});
      return found;
    };
    const double meets = before - radius * std::tan(0.5 * bend);  // m from where it starts
    for (const double shift : {0.0, 0.99 * meets, -way, bend > 0 ? 0.0 : way}) {
      const SurfaceManifolds found = touch_in_step(shift);
      ASSERT_EQ(found.count, 1) << bend << ", " << shift;
      EXPECT_LT((found.manifolds[0].normal - Vector3::UnitZ()).norm(), 1e-12);
    }
    if (bend < 0) continue;
    const SurfaceManifolds found = touch_in_step(way);
    ASSERT_EQ(found.count, 2) << bend;
    EXPECT_NEAR(found.manifolds[0].min_separation(), 0, 1e-12);
    EXPECT_LT((found.manifolds[1].normal - Vector3(-std::sin(bend), 0, std::cos(bend))).norm(), 1e-12);
    EXPECT_NEAR(found.manifolds[1].min_separation(), meets * std::sin(bend), 1e-12);
    EXPECT_EQ(found.manifolds[1].rise, 0);
  }
}

// Facets that differ by less than a degree are as one to a solid with a face, but not to a ball: each pushes along its
// own normal while the ball is over it.
TEST(PlainSurface, ABallHasTheNormalOfEachFacetThatItIsOver) {
  const double bend = 0.015, radius = 0.1;
  const TriangleMesh mesh = bent_floor(bend);
  const Vector3 up = Vector3::UnitZ(), beyond(-std::sin(bend), 0, std::cos(bend));
  for (int i = -20; i <= 20; ++i) {
    const Vector3 centre(1e-4 * i, 0.3, radius);
    const SurfaceManifolds found =
        touch(Shape::sphere(radius), Shape::triangle_mesh(mesh), {centre, Quaternion::Identity()}, 0.02);
    const double along_beyond = centre.x() * std::cos(bend) + radius * std::sin(bend);  // m, of the foot from the edge
    if (std::min(std::abs(centre.x()), std::abs(along_beyond)) < 1.5e-4) continue;      // as good as over the edge
    ASSERT_EQ(found.count, (centre.x() < 0 ? 1 : 0) + (along_beyond > 0 ? 1 : 0)) << centre.x();
    for (int k = 0; k < found.count; ++k) {
      const Manifold& manifold = found.manifolds[static_cast<std::size_t>(k)];
      const Vector3& normal = manifold.normal.x() < -0.5 * bend ? beyond : up;
      EXPECT_LT((manifold.normal - normal).norm(), 1e-12);
      EXPECT_NEAR(manifold.min_separation(), normal.dot(centre) - radius, 1e-12);
    }
  }
}

// Across the bowl, along a great circle: the normal is that half way, and the surface rises by the centripetal motion.
TEST(SmoothSurface, BendsUnderABallThatSlides) {
  const TriangleMesh mesh = bowl(20, 80, 0.3);
  const double out = 0.4, step = 0.03, turn = step / 0.9;
  const auto towards = [](double angle) { return Vector3(std::sin(angle), 0, -std::cos(angle)); };
  const Vector3 shift = step * Vector3(std::cos(out), 0, std::sin(out));
  SurfaceManifolds found;
  collide_surface(Shape::sphere(0.1), Shape::triangle_mesh(mesh),
                  {Vector3::UnitZ() + 0.9 * towards(out), Quaternion::Identity()}, 0.02, found, shift);
  ASSERT_EQ(found.count, 1);
  EXPECT_LT((found.manifolds[0].normal + towards(out + turn / 2)).norm(), 1e-3);
  EXPECT_NEAR(found.manifolds[0].rise, 0.5 * turn * step, 0.05 * 0.5 * turn * step);
}

// An edge that bends by more than the angle is a crease: normals on either side are those of their own triangles.
TEST(SmoothSurface, KeepsCreases) {
  const auto roof = [](double x, double) { return -0.5 * std::abs(x); };
  for (const bool smooth : {false, true}) {
    TriangleMesh mesh = grid(8, 1, roof);
    mesh = std::get<TriangleMesh>(build_triangle_mesh(mesh.vertices, mesh.triangles, smooth ? 1.5 : 0.5));
    const Vector3 side = Vector3(0.5, 0, 1).normalized();
    const Vector3 centre = Vector3(0.2, 0.1, -0.1) + 0.1 * side;
    const SurfaceManifolds found =
        touch(Shape::sphere(0.1), Shape::triangle_mesh(mesh), {centre, Quaternion::Identity()}, 0.02);
    ASSERT_EQ(found.count, 1);
    const double off = (found.manifolds[0].normal - side).norm();
    if (smooth) {
      EXPECT_GT(off, 0.05);
    } else {
      EXPECT_LT(off, 1e-12);
    }
  }
}

TEST(SmoothSurface, AHeightFieldHasTheNormalsOfItsSlopes) {
  constexpr std::uint32_t samples = 41;
  constexpr double cell = 0.05;
  std::vector<double> heights;
  const auto height = [](double x, double y) { return 0.3 * (x - 1) * (x - 1) + 0.2 * (x - 1) * (y - 1); };
  for (std::uint32_t j = 0; j < samples; ++j) {
    for (std::uint32_t i = 0; i < samples; ++i) heights.push_back(height(i * cell, j * cell));
  }
  const auto field = std::get<HeightField>(build_height_field(samples, samples, cell, cell, heights, true));
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    const double x = random.real(0.2, 1.8), y = random.real(0.2, 1.8);
    const Vector3 normal = Vector3(-0.6 * (x - 1) - 0.2 * (y - 1), -0.2 * (x - 1), 1).normalized();
    const Vector3 centre = Vector3(x, y, height(x, y)) + 0.1 * normal;
    const SurfaceManifolds found =
        touch(Shape::sphere(0.1), Shape::height_field(field), {centre, Quaternion::Identity()}, 0.02);
    ASSERT_EQ(found.count, 1);
    EXPECT_LT((found.manifolds[0].normal - normal).norm(), 2e-3);
    EXPECT_NEAR(found.manifolds[0].min_separation(), 0, 1e-5);
  }
}

}  // namespace
}  // namespace atl::collision
