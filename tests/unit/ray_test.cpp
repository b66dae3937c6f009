// Rays against solids, checked by supporting planes and by GJK; against surfaces, checked triangle by triangle.

#include <collision/narrowphase/distance.h>
#include <collision/queries/ray.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/shape.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "support/random.h"
#include "surface_points.h"

namespace atl::collision {
namespace {

using test::Random;

constexpr double infinity = std::numeric_limits<double>::infinity();

Hull random_hull(double size, Random& random) {
  std::vector<Vector3> points(4 + random.below(30));
  for (Vector3& point : points) point = size * random.real(0.5, 1) * random.direction();
  return std::get<Hull>(build_hull(points));
}

std::vector<Shape> solids(const Hull& hull, Random& random) {
  const auto length = [&] { return random.magnitude(0.1, 2); };
  const double r = length();
  const double h = length();
  const double top = length();
  return {Shape::sphere(r),
          Shape::capsule(r, h),
          Shape::box({r, h, length()}),
          Shape::cylinder(r, h),
          Shape::cone(r, h),
          Shape::convex_hull(hull),
          Shape::ellipsoid({r, h, length()}),
          Shape::tapered_capsule(r, top, h + 0.51 * std::abs(r - top))};
}

// How far GJK says that the ray, up to an end beyond the shape, is from the solid; 0 if it hits.
double distance_of(const Shape& shape, const Ray& ray) {
  const double end = std::min(ray.max_t, ray.origin.norm() + 2 * shape.bounding_radius);
  const Vector3 last = ray.origin + end * ray.direction;
  return closest_points(shape, {ray.origin, last, last}).distance;
}

double distance_of(const Shape& shape, const Vector3& point) {
  return closest_points(shape, {point, point, point}).distance;
}

// A point of the solid that lies on a plane which has the solid behind it, and which the ray crosses from the
// front, is where the ray enters.
void expect_entry(const Shape& shape, const Ray& ray, const RayHit& hit) {
  const Vector3 point = ray.origin + hit.t * ray.direction;
  const double tolerance = 1e-12 * (shape.bounding_radius + ray.origin.norm());
  EXPECT_NEAR(hit.normal.norm(), 1, 1e-12);
  EXPECT_LE(hit.normal.dot(ray.direction), 1e-12);
  EXPECT_LE(distance_of(shape, point), tolerance) << "kind " << int(shape.kind);
  // A flat cone's or grazed tube's normal turns fast along the ray; but the plane's reach is what counts.
  EXPECT_NEAR(reach_along(shape, hit.normal), hit.normal.dot(point), 1e-9 * shape.bounding_radius)
      << "kind " << int(shape.kind);
  EXPECT_FALSE(hit.started_inside);
}

TEST(RaySolids, HitWhereTheyEnterAndMissWhereTheyAreApart) {
  Random random(1);
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 4000; ++i) {
    const Hull hull = random_hull(random.magnitude(0.1, 2), random);
    for (const Shape& shape : solids(hull, random)) {
      const double size = shape.bounding_radius;
      const Vector3 origin = size * random.magnitude(1.001, 1000) * random.direction();
      const Vector3 target = random.vector(0.8 * size);
      Ray ray{origin, (target - origin).normalized(), infinity};
      if (random.chance(0.3)) ray.max_t = random.real(0.5, 1.2) * (target - origin).norm();
      // Along an axis, where many terms are zero.
      if (random.chance(0.1)) {
        const Eigen::Index axis = random.below(3);
        ray = {target - 3 * size * Vector3::Unit(axis), Vector3::Unit(axis), infinity};
      }
      const double apart = distance_of(shape, ray);
      RayHit hit;
      const bool found = cast_ray(shape, ray, Sides::Front, hit);
      if (apart > 1e-9 * size) {
        EXPECT_FALSE(found) << "kind " << int(shape.kind) << " apart " << apart;
        ++misses;
      } else if (found) {
        expect_entry(shape, ray, hit);
        EXPECT_LE(hit.t, ray.max_t);
        ++hits;
      } else {
        // Touched at most: a little further in it would hit.
        EXPECT_FALSE(true) << "kind " << int(shape.kind) << " origin " << ray.origin.transpose() << " direction "
                           << ray.direction.transpose();
      }
    }
  }
  EXPECT_GT(hits, 5000);
  EXPECT_GT(misses, 3000);
}

TEST(RaySolids, StartingInsideHitsAtOnce) {
  Random random(2);
  for (int i = 0; i < 500; ++i) {
    const Hull hull = random_hull(1, random);
    for (const Shape& shape : solids(hull, random)) {
      const auto a = test::random_surface_point(shape, random);
      const auto b = test::random_surface_point(shape, random);
      Vector3 inside = 0.4 * a.point + 0.4 * b.point;
      if (shape.kind == ShapeKind::Hull) inside = 0.9 * shape.hull->mass.centre + 0.1 * a.point;
      if (shape.kind == ShapeKind::Cone) inside.z() -= 0.1 * shape.half_height;
      const Ray ray{inside, random.direction(), random.real(0, 1)};
      RayHit hit;
      ASSERT_TRUE(cast_ray(shape, ray, Sides::Front, hit)) << int(shape.kind);
      EXPECT_TRUE(hit.started_inside);
      EXPECT_EQ(hit.t, 0);
      EXPECT_EQ(hit.normal, -ray.direction);
    }
  }
}

TEST(RaySolids, GoingOnFromAHitLeavesTheSurface) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Hull hull = random_hull(1, random);
    for (const Shape& shape : solids(hull, random)) {
      const Vector3 origin = 2 * shape.bounding_radius * random.direction();
      const Ray ray{origin, (random.vector(0.3 * shape.bounding_radius) - origin).normalized(), infinity};
      RayHit hit;
      if (!cast_ray(shape, ray, Sides::Front, hit) || hit.normal.dot(ray.direction) > -0.1) continue;
      const Vector3 point = origin + hit.t * ray.direction;
      RayHit again;
      EXPECT_FALSE(cast_ray(shape, {point, hit.normal, infinity}, Sides::Front, again)) << int(shape.kind);
      ASSERT_TRUE(cast_ray(shape, {point, ray.direction, infinity}, Sides::Front, again)) << int(shape.kind);
      EXPECT_NEAR(again.t, 0, 1e-12 * shape.bounding_radius);
    }
  }
}

TEST(RaySolids, FarStartsCostNoPrecision) {
  RayHit hit;
  const Vector3 direction = Vector3(1, 2, -3).normalized();
  const Vector3 origin = -1e6 * direction;
  for (const Shape& shape : {Shape::sphere(0.5), Shape::capsule(0.5, 1), Shape::box({1, 1, 1}), Shape::cylinder(0.5, 1),
                             Shape::cone(0.5, 1)}) {
    const Ray near{-10 * direction, direction, infinity};
    RayHit near_hit;
    ASSERT_TRUE(cast_ray(shape, near, Sides::Front, near_hit));
    ASSERT_TRUE(cast_ray(shape, {origin, direction, infinity}, Sides::Front, hit));
    EXPECT_NEAR(hit.t - 1e6, near_hit.t - 10, 1e-9);
    EXPECT_LT((hit.normal - near_hit.normal).norm(), 1e-9);
  }
}

TEST(RayHalfSpace, HitsItsPlaneFromOutsideOnly) {
  const Shape ground = Shape::half_space(Vector3(0.6, 0, 0.8), 2);
  RayHit hit;
  ASSERT_TRUE(cast_ray(ground, {Vector3(0, 0, 12.5), -Vector3::UnitZ(), infinity}, Sides::Front, hit));
  EXPECT_NEAR(hit.t, 10, 1e-12);
  EXPECT_EQ(hit.normal, ground.normal);
  EXPECT_FALSE(cast_ray(ground, {Vector3(0, 0, 12.5), -Vector3::UnitZ(), 9.99}, Sides::Front, hit));
  EXPECT_FALSE(cast_ray(ground, {Vector3(0, 0, 12.5), Vector3::UnitZ(), infinity}, Sides::Front, hit));
  EXPECT_FALSE(cast_ray(ground, {Vector3(0, 0, 12.5), Vector3::UnitY(), infinity}, Sides::Front, hit));
  ASSERT_TRUE(cast_ray(ground, {Vector3(0, 0, 0), Vector3::UnitZ(), infinity}, Sides::Front, hit));
  EXPECT_TRUE(hit.started_inside);
}

// By the plane's equation and the point's barycentric coordinates.
std::optional<double> hit_triangle(const std::array<Vector3, 3>& p, const Ray& ray, Sides sides) {
  const Vector3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
  const double speed = normal.dot(ray.direction);
  if (speed == 0 || (speed > 0 && sides == Sides::Front)) return std::nullopt;
  const double t = normal.dot(p[0] - ray.origin) / speed;
  const Vector3 point = ray.origin + t * ray.direction;
  if (t < 0 || t > ray.max_t) return std::nullopt;
  for (std::size_t i = 0; i < 3; ++i) {
    if (normal.dot((p[(i + 1) % 3] - p[i]).cross(point - p[i])) < 0) return std::nullopt;
  }
  return t;
}

template <typename Surface>
void expect_as_brute_force(const Surface& surface, std::uint32_t triangles, const Shape& shape, const Ray& ray,
                           Sides sides) {
  std::optional<double> expected;
  for (std::uint32_t k = 0; k < triangles; ++k) {
    const std::optional<double> t = hit_triangle(surface.triangle(k).vertices, ray, sides);
    if (t && (!expected || *t < *expected)) expected = t;
  }
  RayHit hit;
  const bool found = cast_ray(shape, ray, sides, hit);
  ASSERT_EQ(found, expected.has_value()) << ray.origin.transpose() << " along " << ray.direction.transpose();
  if (!found) return;
  EXPECT_NEAR(hit.t, *expected, 1e-11 * (1 + ray.origin.norm()));
  const Triangle triangle = surface.triangle(hit.triangle);
  EXPECT_TRUE(hit_triangle(triangle.vertices, {ray.origin, ray.direction, infinity}, sides).has_value());
  EXPECT_EQ(hit.back, triangle.normal.dot(ray.direction) > 0);
  EXPECT_LT((hit.normal - (hit.back ? -1 : 1) * triangle.normal).norm(), 1e-12);
}

// A closed, bumpy ball of longitudes and latitudes.
TriangleMesh bumpy_ball(std::uint32_t around, std::uint32_t up, Random& random) {
  std::vector<Vector3> vertices{-Vector3::UnitZ(), Vector3::UnitZ()};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return 2 + (j - 1) * around + i % around; };
  for (std::uint32_t j = 1; j < up; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double latitude = std::numbers::pi * (double(j) / up - 0.5);
      const double r = random.real(0.8, 1.2);
      vertices.push_back(r * test::around_z(2 * std::numbers::pi * i / around, std::cos(latitude), std::sin(latitude)));
    }
  }
  for (std::uint32_t i = 0; i < around; ++i) {
    triangles.push_back({0, at(i + 1, 1), at(i, 1)});
    triangles.push_back({1, at(i, up - 1), at(i + 1, up - 1)});
    for (std::uint32_t j = 1; j + 1 < up; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles));
}

TEST(RayMesh, MatchesAllTriangles) {
  Random random(4);
  const TriangleMesh mesh = bumpy_ball(24, 12, random);
  const Shape shape = Shape::triangle_mesh(mesh);
  for (int i = 0; i < 3000; ++i) {
    const Vector3 origin = random.magnitude(0.1, 100) * random.direction();
    const Vector3 direction = (random.vector(1) - origin).normalized();
    const Ray ray{origin, direction, random.chance(0.5) ? infinity : random.real(0, 3)};
    expect_as_brute_force(mesh, std::uint32_t(mesh.triangles.size()), shape, ray,
                          random.chance(0.5) ? Sides::Both : Sides::Front);
  }
}

// From inside a closed surface no ray gets out, even along edges and through vertices.
TEST(RayMesh, LetsNothingThroughItsEdges) {
  Random random(5);
  const TriangleMesh mesh = bumpy_ball(24, 12, random);
  const Shape shape = Shape::triangle_mesh(mesh);
  RayHit hit;
  for (int i = 0; i < 20000; ++i) {
    const auto& corners = mesh.triangles[random.below(std::uint32_t(mesh.triangles.size()))];
    const double t = random.chance(0.3) ? 0 : random.real(0, 1);
    const Vector3 target = mesh.vertices[corners[0]] + t * (mesh.vertices[corners[1]] - mesh.vertices[corners[0]]);
    const Vector3 origin = random.chance(0.5) ? Vector3::Zero() : random.vector(0.3);
    ASSERT_TRUE(cast_ray(shape, {origin, (target - origin).normalized(), infinity}, Sides::Both, hit));
    if (origin.isZero()) {
      EXPECT_TRUE(hit.back);
    }
    const Vector3 outside = random.magnitude(2, 100) * random.direction();
    EXPECT_TRUE(cast_ray(shape, {outside, -outside.normalized(), infinity}, Sides::Front, hit));
  }
}

HeightField bumpy_field(std::uint32_t columns, std::uint32_t rows, Random& random) {
  std::vector<double> heights(std::size_t{columns} * rows);
  for (double& height : heights) height = random.real(-1, 1);
  return std::get<HeightField>(build_height_field(columns, rows, 0.7, 1.3, heights));
}

TEST(RayHeightField, MatchesAllTriangles) {
  Random random(6);
  const HeightField field = bumpy_field(14, 9, random);
  const Shape shape = Shape::height_field(field);
  const Vector3 extent(13 * 0.7, 8 * 1.3, 0);
  for (int i = 0; i < 4000; ++i) {
    const Vector3 target = random.vector(0.6).cwiseProduct(extent) + 0.5 * extent + Vector3(0, 0, random.real(-1, 1));
    const Vector3 origin = target + random.magnitude(0.1, 100) * random.direction();
    const Ray ray{origin, (target - origin).normalized(), random.chance(0.5) ? infinity : random.real(0, 10)};
    expect_as_brute_force(field, field.triangle_count(), shape, ray, random.chance(0.5) ? Sides::Both : Sides::Front);
  }
}

TEST(RayHeightField, LetsNothingThroughItsEdges) {
  Random random(7);
  const HeightField field = bumpy_field(14, 9, random);
  const Shape shape = Shape::height_field(field);
  RayHit hit;
  for (std::uint32_t j = 0; j < field.rows; ++j) {
    for (std::uint32_t i = 0; i < field.columns; ++i) {
      // Straight down on every sample, and slantwise at inner ones.
      const Vector3 sample(i * field.spacing_x, j * field.spacing_y, field.height(i, j));
      ASSERT_TRUE(cast_ray(shape, {sample + 5 * Vector3::UnitZ(), -Vector3::UnitZ(), infinity}, Sides::Front, hit));
      EXPECT_NEAR(hit.t, 5, 1e-12);
      if (i == 0 || j == 0 || i + 1 == field.columns || j + 1 == field.rows) continue;
      for (int k = 0; k < 20; ++k) {
        const Vector3 origin = sample + Vector3(random.real(-0.1, 0.1), random.real(-0.1, 0.1), 5);
        EXPECT_TRUE(cast_ray(shape, {origin, (sample - origin).normalized(), infinity}, Sides::Front, hit));
      }
    }
  }
  // Along grid lines, at a slant: down on a field whose edges they then run along.
  for (std::uint32_t j = 1; j + 1 < field.rows; ++j) {
    const Vector3 start(-1, j * field.spacing_y, 3);
    EXPECT_TRUE(cast_ray(shape, {start, Vector3(2, 0, -1).normalized(), infinity}, Sides::Front, hit));
    EXPECT_TRUE(cast_ray(shape, {Vector3(0, 0, 2), Vector3(1, 1.3 / 0.7, -0.5).normalized(), 50}, Sides::Front, hit));
  }
}

TEST(Ray, NumbersThatAreNotFiniteHitNothing) {
  Random random(8);
  const TriangleMesh mesh = bumpy_ball(8, 4, random);
  const HeightField field = bumpy_field(4, 4, random);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Shape& shape :
       {Shape::sphere(1), Shape::capsule(1, 1), Shape::box({1, 1, 1}), Shape::cylinder(1, 1), Shape::cone(1, 1),
        Shape::half_space(Vector3::UnitZ(), 0), Shape::triangle_mesh(mesh), Shape::height_field(field)}) {
    RayHit hit;
    EXPECT_FALSE(cast_ray(shape, {Vector3(nan, 0, 5), -Vector3::UnitZ(), infinity}, Sides::Both, hit));
    EXPECT_FALSE(cast_ray(shape, {Vector3(0, 0, 5), -Vector3::UnitZ(), nan}, Sides::Both, hit));
  }
}

}  // namespace
}  // namespace atl::collision
