// Degenerate and extreme pairs: whatever the poses and sizes, the narrowphase answers, with finite numbers, and the
// world lives on. ATOLL_LONG_TESTS=1 makes ten million calls.

#include <collision/continuous/sweep.h>
#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/distance.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/height_field.h>
#include <collision/shapes/hull.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "support/long_tests.h"
#include "support/random.h"

namespace atl::collision {
namespace {

using test::long_tests;
using test::Random;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// Hulls and surfaces of a unit size, and flat and thin ones.
struct Library {
  std::vector<Hull> hulls;
  std::vector<TriangleMesh> meshes;
  std::vector<HeightField> fields;

  Library() {
    Random random(7);
    for (const Vector3& stretch : {Vector3(1, 1, 1), Vector3(1, 1, 1e-4), Vector3(1, 1e-4, 1e-4), Vector3(1e3, 1, 1)}) {
      for (const int count : {4, 8, 20, 60}) {
        std::vector<Vector3> points;
        for (int i = 0; i < count; ++i) points.push_back(random.direction().cwiseProduct(stretch));
        auto hull = build_hull(points);
        if (Hull* made = std::get_if<Hull>(&hull)) hulls.push_back(std::move(*made));
      }
    }
    std::vector<Vector3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::uint32_t i = 0; i < 25; ++i) {
      vertices.emplace_back(i % 5 - 2.0, i / 5 - 2.0, random.real(-0.4, 0.4));
      if (i % 5 == 4 || i / 5 == 4) continue;
      triangles.push_back({i, i + 1, i + 6});
      triangles.push_back({i, i + 6, i + 5});
    }
    meshes.push_back(std::get<TriangleMesh>(build_triangle_mesh(vertices, triangles)));
    std::vector<double> heights(36);
    for (double& height : heights) height = random.real(-0.5, 0.5);
    fields.push_back(std::get<HeightField>(build_height_field(6, 6, 0.7, 0.7, heights)));
  }
};

Shape random_solid(Random& random, const Library& library, double size) {
  const double thin = random.chance(0.3) ? random.magnitude(1e-5, 1) : 1;
  switch (random.below(6)) {
    case 0:
      return Shape::sphere(size);
    case 1:
      return Shape::capsule(size * thin, size);
    case 2:
      return Shape::box(size * Vector3(1, thin, random.chance(0.5) ? 1 : thin));
    case 3:
      return random.chance(0.5) ? Shape::cylinder(size, size * thin) : Shape::cylinder(size * thin, size);
    case 4:
      return random.chance(0.5) ? Shape::cone(size, size * thin) : Shape::cone(size * thin, size);
    default:
      return Shape::convex_hull(library.hulls[random.below(static_cast<std::uint32_t>(library.hulls.size()))]);
  }
}

// Poses at which things go wrong: nothing moved, exactly touching, turned by right angles, far, not finite.
Pose awkward_pose(Random& random, double reach) {
  Pose pose{Vector3::Zero(), Quaternion::Identity()};
  switch (random.below(6)) {
    case 0:
      break;
    case 1:
      pose.position = Vector3::Unit(random.below(3)) * reach;
      break;
    case 2:
      pose.position = random.vector(1e-12 * reach);
      break;
    default:
      pose.position = random.vector(reach);
      break;
  }
  switch (random.below(4)) {
    case 0:
      break;
    case 1:
      pose.orientation = Eigen::AngleAxisd(0.5 * EIGEN_PI * random.below(4), Vector3::Unit(random.below(3)));
      break;
    case 2:
      pose.orientation = random.rotation(1e-7);
      break;
    default:
      pose.orientation = random.rotation();
      break;
  }
  return pose;
}

bool spoil(Random& random, Pose& pose) {
  if (!random.chance(0.01)) return false;
  const double bad[] = {nan, infinity, -infinity, 1e300};
  const double value = bad[random.below(4)];
  if (random.chance(0.5)) {
    pose.position[random.below(3)] = value;
  } else {
    pose.orientation.coeffs()[random.below(4)] = value;
  }
  return true;
}

// Finite, few enough, with a unit normal; of poses that are not finite, anything that doesn't crash.
::testing::AssertionResult is_sane(const Manifold& manifold, double margin) {
  if (manifold.count < 0 || manifold.count > max_points)
    return ::testing::AssertionFailure() << manifold.count << " points";
  for (int i = 0; i < manifold.count; ++i) {
    const Manifold::Point& point = manifold.points[static_cast<std::size_t>(i)];
    if (!point.position.allFinite() || !std::isfinite(point.separation)) {
      return ::testing::AssertionFailure() << "a point at " << point.position.transpose() << ", " << point.separation;
    }
    if (point.separation > margin * (1 + 1e-9) + 1e-12) {
      return ::testing::AssertionFailure() << "separation " << point.separation << " beyond the margin " << margin;
    }
    for (int j = 0; j < i; ++j) {
      if (manifold.points[static_cast<std::size_t>(j)].id == point.id) {
        return ::testing::AssertionFailure() << "two points of id " << point.id;
      }
    }
  }
  if (manifold.count > 0 && !(std::abs(manifold.normal.norm() - 1) < 1e-6)) {
    return ::testing::AssertionFailure() << "normal " << manifold.normal.transpose();
  }
  return ::testing::AssertionSuccess();
}

TEST(NarrowphaseFuzz, AnswersAreFinite) {
  const Library library;
  Random random(11);
  const int calls = long_tests() ? 10'000'000 : 100'000;
  int failures = 0;
  for (int call = 0; call < calls && failures < 10; ++call) {
    const double size_a = random.magnitude(1e-3, 10);
    const double size_b = random.chance(0.2) ? size_a : size_a * random.magnitude(1e-5, 1e5);
    Shape a = random_solid(random, library, size_a);
    Shape b = random.chance(0.1) ? a : random_solid(random, library, size_b);
    const double reach = a.bounding_radius + b.bounding_radius;
    Pose pose = awkward_pose(random, random.chance(0.3) ? a.inner_radius + b.inner_radius : reach);
    const bool spoilt = spoil(random, pose);
    const double margin = random.chance(0.2) ? 0 : 0.05 * std::min(a.inner_radius, b.inner_radius);
    if (b.kind < a.kind) std::swap(a, b);
    Manifold manifold;
    switch (random.below(4)) {
      case 0: {
        const Shape plane = Shape::half_space(random.direction(), random.real(-1, 1));
        collide(a, plane, pose, margin, manifold);
        break;
      }
      case 1: {
        SurfaceManifolds found;
        const Shape surface =
            random.chance(0.5) ? Shape::triangle_mesh(library.meshes[0]) : Shape::height_field(library.fields[0]);
        collide_surface(a, surface, pose, margin, found);
        if (found.count < 0 || found.count > max_surface_manifolds) ++failures;
        for (int i = 0; i < found.count && !spoilt; ++i) {
          const auto sane = is_sane(found.manifolds[static_cast<std::size_t>(i)], margin);
          failures += !sane;
          EXPECT_TRUE(sane) << "call " << call << ", surface, kind " << static_cast<int>(a.kind);
        }
        break;
      }
      default:
        collide(a, b, pose, margin, manifold);
        break;
    }
    if (spoilt) continue;
    const auto sane = is_sane(manifold, margin);
    failures += !sane;
    EXPECT_TRUE(sane) << "call " << call << ", kinds " << static_cast<int>(a.kind) << " and "
                      << static_cast<int>(b.kind);
    if (call % 16 == 0) {
      const ClosestPoints closest = closest_points(a, b, pose);
      const bool finite = std::isfinite(closest.distance) && closest.on_first.allFinite() &&
                          closest.on_second.allFinite() && closest.normal.allFinite();
      failures += !finite;
      EXPECT_TRUE(finite) << "closest points, call " << call;
    }
    if (call % 64 == 0) {
      SweepHit hit;
      const Motion motion = Motion::between(pose, awkward_pose(random, reach), Vector3::Zero());
      sweep(b, motion, a, Motion::still({Vector3::Zero(), Quaternion::Identity()}),
            {0, 1e-3 * std::min(a.inner_radius, b.inner_radius)}, 1, hit);
      const bool fine = hit.t >= 0 && hit.t <= 1 && hit.normal.allFinite();
      failures += !fine;
      EXPECT_TRUE(fine) << "sweep, call " << call;
    }
  }
}

}  // namespace
}  // namespace atl::collision
