// Queries of many colliders, against asking each one.

#include <collision/narrowphase/distance.h>
#include <collision/queries/query.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

constexpr double infinity = std::numeric_limits<double>::infinity();

// Solids of all kinds scattered over a field, a mesh and a half-space; every third body has two of them.
class ColliderQueries : public testing::Test {
 protected:
  ColliderQueries() : hull_(box_hull({0.2, 0.3, 0.4})) {
    std::vector<double> heights(100);
    for (double& height : heights) height = random_.real(-1, 0);
    field_ = std::get<HeightField>(build_height_field(10, 10, 1, 1, heights));
    const std::vector<Vector3> corners{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
    const std::vector<std::array<std::uint32_t, 3>> faces{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    mesh_ = std::get<TriangleMesh>(build_triangle_mesh(corners, faces));
    add_body({Vector3(-5, -5, -4), Quaternion::Identity()}, {{Shape::height_field(field_), unplaced}});
    add_body({Vector3(2, 2, 1), random_.rotation()}, {{Shape::triangle_mesh(mesh_), unplaced}});
    add_body({Vector3(0, 0, -6), random_.rotation(0.2)}, {{Shape::half_space(Vector3::UnitZ(), 0), unplaced}});
    const Shape shapes[] = {Shape::sphere(0.4),        Shape::capsule(0.2, 0.3), Shape::box({0.2, 0.5, 0.3}),
                            Shape::cylinder(0.4, 0.3), Shape::cone(0.4, 0.4),    Shape::convex_hull(hull_)};
    for (std::uint32_t i = 0; i < 150; ++i) {
      std::vector<std::pair<Shape, Pose>> parts{{shapes[i % 6], unplaced}};
      if (i % 3 == 0) parts.push_back({shapes[random_.below(6)], {random_.vector(1), random_.rotation()}});
      add_body({random_.vector(5), random_.rotation()}, parts);
    }
  }

  void add_body(const Pose& pose, const std::vector<std::pair<Shape, Pose>>& parts) {
    const auto body = static_cast<std::uint32_t>(positions_.size() / 3);
    for (int i = 0; i < 3; ++i) positions_.push_back(pose.position[i]);
    for (int i = 0; i < 4; ++i) orientations_.push_back(pose.orientation.coeffs()[i]);
    for (std::uint32_t child = 0; child < parts.size(); ++child) {
      const auto& [shape, local] = parts[child];
      const std::uint32_t collider = colliders_.add(body, child, shape, local);
      const Pose at = colliders_.pose(collider, {positions_.data(), orientations_.data()});
      if (shape.kind == ShapeKind::HalfSpace) {
        const Vector3 normal = at.orientation * shape.normal;
        broadphase_.add_half_space(collider, {normal, shape.offset + normal.dot(at.position)});
      } else {
        const Bounds bounds = bounds_of(shape, at.position, at.orientation.toRotationMatrix());
        const Vector3 slack = Vector3::Constant(random_.real(0, 0.2));
        broadphase_.add_box(collider, Aabb::around(bounds.lower - slack, bounds.upper + slack), body < 3);
      }
    }
  }

  QueryScene scene() const { return {colliders_, {positions_.data(), orientations_.data()}, broadphase_}; }
  std::uint32_t count() const { return static_cast<std::uint32_t>(colliders_.size()); }
  Pose pose(std::uint32_t collider) const { return colliders_.pose(collider, scene().poses); }

  Random random_{1};
  static inline const Pose unplaced{Vector3::Zero(), Quaternion::Identity()};
  Hull hull_;
  HeightField field_;
  TriangleMesh mesh_;
  ColliderTable colliders_;
  std::vector<double> positions_, orientations_;
  Broadphase broadphase_;
};

const auto everything = [](std::uint32_t) { return true; };
const auto odd_ones = [](std::uint32_t collider) { return collider % 2 == 1; };

TEST_F(ColliderQueries, RaysMatchCastingAtEach) {
  int hits = 0;
  std::vector<ColliderRayHit> all;
  for (int i = 0; i < 2000; ++i) {
    const Vector3 origin = random_.vector(8);
    const Ray ray{origin, random_.direction(), random_.chance(0.5) ? infinity : random_.real(0, 10)};
    const Accept accept = i % 2 ? Accept(everything) : Accept(odd_ones);
    std::vector<std::pair<double, std::uint32_t>> expected;
    for (std::uint32_t c = 0; c < count(); ++c) {
      const Pose at = pose(c);
      RayHit hit;
      const Ray seen{at.orientation.conjugate() * (origin - at.position), at.orientation.conjugate() * ray.direction,
                     ray.max_t};
      if (accept(c) && cast_ray(colliders_.shape[c], seen, Sides::Front, hit)) expected.push_back({hit.t, c});
    }
    std::sort(expected.begin(), expected.end());
    cast_ray_all(scene(), ray, Sides::Front, accept, all);
    ASSERT_EQ(all.size(), expected.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
      EXPECT_EQ(all[k].hit.t, expected[k].first);
      EXPECT_EQ(all[k].collider, expected[k].second);
      EXPECT_LT((all[k].point - origin - all[k].hit.t * ray.direction).norm(), 1e-12);
      if (all[k].hit.started_inside) {
        EXPECT_GE(all[k].depth, 0);
      } else {
        EXPECT_LE(all[k].hit.normal.dot(ray.direction), 1e-12);
        EXPECT_EQ(all[k].depth, 0);
      }
    }
    ColliderRayHit first;
    ColliderRayHit any;
    ASSERT_EQ(cast_ray(scene(), ray, Sides::Front, accept, first), !expected.empty());
    ASSERT_EQ(cast_ray_any(scene(), ray, Sides::Front, accept, any), !expected.empty());
    if (expected.empty()) continue;
    ++hits;
    EXPECT_EQ(first.collider, expected[0].second);
    EXPECT_EQ(first.hit.t, expected[0].first);
    EXPECT_TRUE(std::any_of(expected.begin(), expected.end(), [&](const auto& e) { return e.second == any.collider; }));
  }
  EXPECT_GT(hits, 500);
}

TEST_F(ColliderQueries, OverlapsAndClosestMatchAskingEach) {
  std::vector<std::uint32_t> found;
  int apart = 0;
  for (int i = 0; i < 600; ++i) {
    const Shape solid = i % 3 == 0 ? Shape::sphere(0) : (i % 3 == 1 ? Shape::box({0.3, 0.4, 0.5}) : Shape::cone(1, 1));
    const Pose at{random_.vector(7), random_.rotation()};
    const Accept accept = i % 2 ? Accept(everything) : Accept(odd_ones);
    const double limit = random_.magnitude(0.01, 30);
    std::vector<std::uint32_t> touching;
    double least = infinity;
    std::size_t near = 0;
    for (std::uint32_t c = 0; c < count(); ++c) {
      Distance distance;
      if (!accept(c) || !find_signed_distance(solid, at, colliders_.shape[c], pose(c), infinity, distance)) continue;
      if (distance.distance <= 0) touching.push_back(c);
      near += distance.distance <= limit;
      least = std::min(least, distance.distance);
    }
    std::vector<ColliderDistance> all;
    find_near(scene(), solid, at, limit, accept, all);
    EXPECT_EQ(all.size(), near);
    find_overlaps(scene(), solid, at, accept, found);
    EXPECT_EQ(found, touching);
    ColliderDistance closest;
    ASSERT_EQ(find_closest(scene(), solid, at, limit, accept, closest), least <= limit);
    if (least > limit) continue;
    EXPECT_EQ(closest.distance.distance, least);
    EXPECT_EQ(all[0].collider, closest.collider);
    EXPECT_EQ(all[0].distance.distance, least);
    if (least <= 0) continue;
    ++apart;
    const Vector3 way = closest.distance.on_other - closest.distance.on_solid;
    EXPECT_LT((way - least * closest.distance.normal).norm(), 1e-7);
    // The point on the other does lie there.
    Distance check;
    const Pose there{closest.distance.on_other, Quaternion::Identity()};
    ASSERT_TRUE(find_distance(Shape::sphere(0), there, colliders_.shape[closest.collider], pose(closest.collider), 1e-6,
                              check));
  }
  EXPECT_GT(apart, 100);
}

TEST_F(ColliderQueries, ShapeCastsMatchSweepingAtEach) {
  std::vector<ColliderSweepHit> all;
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape solid = i % 2 ? Shape::sphere(0.3) : Shape::box({0.3, 0.1, 0.2});
    const Pose at{random_.vector(7), random_.rotation()};
    const Vector3 translation = random_.magnitude(0.1, 20) * random_.direction();
    cast_shape_all(scene(), solid, at, translation, everything, all);
    std::size_t expected = 0;
    for (std::uint32_t c = 0; c < count(); ++c) {
      SweepHit hit;
      const SweepGoal goal{0, 1e-9};
      if (!sweep(solid, Motion::along(at, translation), colliders_.shape[c], Motion::still(pose(c)), goal, 1, hit))
        continue;
      ++expected;
      const auto same = std::find_if(all.begin(), all.end(), [&](const auto& found) { return found.collider == c; });
      ASSERT_NE(same, all.end());
      EXPECT_NEAR(same->hit.t * translation.norm(), hit.t * translation.norm(), 1e-4);
    }
    EXPECT_EQ(all.size(), expected);
    for (std::size_t k = 1; k < all.size(); ++k) EXPECT_LE(all[k - 1].hit.t, all[k].hit.t);
    ColliderSweepHit first;
    ASSERT_EQ(cast_shape(scene(), solid, at, translation, everything, first), !all.empty());
    if (all.empty()) continue;
    ++hits;
    EXPECT_EQ(first.collider, all[0].collider);
    EXPECT_EQ(first.hit.t, all[0].hit.t);
    // A surface's back and what the solid starts behind don't count in a cast, but they do in a distance.
    if (first.hit.started_overlapping || is_surface(colliders_.shape[first.collider].kind)) continue;
    // At the hit it is that near, and at no time before nearer.
    Distance distance;
    const Pose there{at.position + first.hit.t * translation, at.orientation};
    ASSERT_TRUE(find_distance(solid, there, colliders_.shape[first.collider], pose(first.collider), 1, distance));
    EXPECT_LT(distance.distance, 1e-7 + 1e-12);
    EXPECT_GT(distance.distance, 0);
  }
  EXPECT_GT(hits, 100);
}

// Casts and distances against a field and a mesh, through every triangle of them.
TEST_F(ColliderQueries, DistanceToSurfacesIsThatOfTheClosestTriangle) {
  for (int i = 0; i < 300; ++i) {
    const Shape solid = i % 2 ? Shape::sphere(0.3) : Shape::capsule(0.1, 0.6);
    const Pose at{random_.vector(9), random_.rotation()};
    for (const std::uint32_t surface : {0u, 1u}) {
      const Shape& shape = colliders_.shape[surface];
      const Pose seen = relative(at, pose(surface));
      const bool mesh = shape.kind == ShapeKind::Mesh;
      const std::uint32_t triangles = mesh ? 4 : field_.triangle_count();
      double least = infinity;
      for (std::uint32_t k = 0; k < triangles; ++k) {
        auto vertices = mesh ? mesh_.triangle(k).vertices : field_.triangle(k).vertices;
        for (Vector3& vertex : vertices) vertex = seen.position + seen.orientation * vertex;
        least = std::min(least, closest_points(solid, vertices).distance);
      }
      Distance found;
      ASSERT_TRUE(find_distance(solid, at, shape, pose(surface), infinity, found));
      EXPECT_EQ(found.distance, least);
      EXPECT_EQ(find_distance(solid, at, shape, pose(surface), 0.99 * least, found), least == 0);
    }
  }
}

}  // namespace
}  // namespace atl::collision
