// The axes that part two boxes, and what FCL makes of the same pairs.

#include <collision/contacts/narrowphase_kernels.h>
#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/fcl_narrowphase.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

constexpr double infinity = std::numeric_limits<double>::infinity();

struct BoxInWorld {
  Vector3 half;
  Pose pose;
};

struct Pairs {
  std::array<BoxInWorld, jobs::block_lanes> first, second;

  explicit Pairs(Random& random) {
    for (std::size_t lane = 0; lane < jobs::block_lanes; ++lane) {
      const Vector3 from = random.vector(100);
      first[lane] = {random.vector(0.4).cwiseAbs() + Vector3::Constant(0.1), {from, random.rotation()}};
      second[lane] = {random.vector(0.4).cwiseAbs() + Vector3::Constant(0.1),
                      {from + random.vector(1), random.rotation()}};
    }
  }

  BoxBlock block() const {
    BoxBlock block;
    for (std::size_t lane = 0; lane < jobs::block_lanes; ++lane) {
      block.position_first[lane] = first[lane].pose.position.data();
      block.orientation_first[lane] = first[lane].pose.orientation.coeffs().data();
      block.half_first[lane] = first[lane].half.data();
      block.position_second[lane] = second[lane].pose.position.data();
      block.orientation_second[lane] = second[lane].pose.orientation.coeffs().data();
      block.half_second[lane] = second[lane].half.data();
    }
    return block;
  }
};

// How far a direction parts the boxes of a lane.
double separation_along(const Pairs& pairs, std::size_t lane, const Vector3& direction) {
  const BoxInWorld& a = pairs.first[lane];
  const BoxInWorld& b = pairs.second[lane];
  const Pose seen = relative(a.pose, b.pose);
  return direction.dot(seen.position) - a.half.dot(direction.cwiseAbs()) -
         b.half.dot((seen.orientation.conjugate() * direction).cwiseAbs());
}

TEST(BoxAxes, PartTheBoxesAsFarAsTheySay) {
  Random random(1);
  int apart = 0;
  int edges = 0;
  for (int i = 0; i < 1000; ++i) {
    const Pairs pairs(random);
    BoxAxes axes;
    widest_box_axes_kernel()(pairs.block(), axes);
    for (std::size_t lane = 0; lane < jobs::block_lanes; ++lane) {
      const Pose seen = relative(pairs.first[lane].pose, pairs.second[lane].pose);
      const Matrix3 rotation = seen.orientation.toRotationMatrix();
      double face = -infinity;
      double edge = -infinity;
      const auto both_ways = [&](const Vector3& axis) {
        return std::max(separation_along(pairs, lane, axis), separation_along(pairs, lane, -axis));
      };
      for (int k = 0; k < 3; ++k) {
        face = std::max({face, both_ways(Vector3::Unit(k)), both_ways(rotation.col(k))});
        for (int l = 0; l < 3; ++l) {
          edge = std::max(edge, both_ways(Vector3::Unit(k).cross(rotation.col(l)).normalized()));
        }
      }
      ASSERT_NEAR(axes.face[lane], face, 1e-12);
      ASSERT_NEAR(axes.edge[lane], edge, 1e-10);
      const auto along = [&](const BoxAxes::Row& code) {
        return separation_along(pairs, lane, box_axis(axes, lane, static_cast<int>(code[lane])));
      };
      ASSERT_NEAR(along(axes.face_code), face, 1e-12);
      ASSERT_NEAR(along(axes.edge_code), edge, 1e-10);
      ASSERT_NEAR(separation_along(pairs, lane, best_box_axis(axes, lane)), std::max(face, edge), 1e-10);
      ASSERT_NEAR(axes.centres[lane], separation_along(pairs, lane, seen.position.normalized()), 1e-12);
      apart += face > 0;
      edges += edge > face;
    }
  }
  EXPECT_GT(apart, 1000);
  EXPECT_GT(edges, 1000);
}

TEST(BoxAxes, AreTheSameInEverySet) {
  std::vector<const NarrowphaseKernels*> sets;
  for (const char* name : {"portable", "sse4", "avx2", "avx512", "neon"}) {
    if (const NarrowphaseKernels* found = find_narrowphase_kernels(name)) sets.push_back(found);
  }
  ASSERT_FALSE(sets.empty());
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Pairs pairs(random);
    BoxAxes expected = {};
    sets.front()->find_box_axes(pairs.block(), expected);
    for (const NarrowphaseKernels* set : sets) {
      BoxAxes axes = {};
      set->find_box_axes(pairs.block(), axes);
      ASSERT_EQ(std::memcmp(&axes, &expected, sizeof(axes)), 0) << set->name;
    }
  }
}

TEST(BoxAxes, AreNoneWherePosesAreNotFinite) {
  Random random(3);
  Pairs pairs(random);
  pairs.second[2].pose.position.x() = std::numeric_limits<double>::quiet_NaN();
  BoxAxes axes;
  widest_box_axes_kernel()(pairs.block(), axes);
  EXPECT_EQ(best_box_axis(axes, 2), Vector3::Zero());
  for (const std::size_t lane : {0u, 1u, 3u}) EXPECT_NE(best_box_axis(axes, lane), Vector3::Zero()) << "lane " << lane;
}

// FCL is not asked about a pair again that meets already: the answer is known.
TEST(BoxAxes, FclIsAskedWhenBoxesComeToMeet) {
  Random random(4);
  int met = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vector3 a = random.vector(0.4).cwiseAbs() + Vector3::Constant(0.1);
    const Vector3 b = random.vector(0.4).cwiseAbs() + Vector3::Constant(0.1);
    const Pose second{random.vector(0.5), random.rotation()};
    const double margin = 0.05 * std::min(a.minCoeff(), b.minCoeff());
    Manifold manifold;
    const Narrowphase by = collide_boxes(a, b, second, margin, manifold);
    if (manifold.count == 0) continue;
    ++met;
    ASSERT_TRUE(asks_fcl(by));
    // From then on the best axis is ours.
    manifold = as_last(manifold);
    ASSERT_EQ(collide_boxes(a, b, second, margin, manifold), Narrowphase::Kept);
    const Manifold first = manifold;
    manifold = as_last(manifold);
    ASSERT_EQ(collide_boxes(a, b, second, margin, manifold), Narrowphase::Kept);
    ASSERT_EQ(manifold.axis, first.axis);
    ASSERT_EQ(manifold.count, first.count);
    for (int k = 0; k < first.count; ++k) {
      const auto point = static_cast<std::size_t>(k);
      ASSERT_EQ(manifold.points[point].id, first.points[point].id);
      ASSERT_EQ(manifold.points[point].separation, first.points[point].separation);
    }
    // FCL's function promises that the boxes meet, and how deep, but prefers a face to edges by a twentieth.
    fcl_narrowphase::Axis found;
    ASSERT_TRUE(fcl_narrowphase::box_box(a, b, second.position, second.orientation.toRotationMatrix(), margin, found));
    BoxAxes axes;
    find_box_axes(a, b, second, axes);
    const double separation = std::max(axes.face[0], axes.edge[0]);
    if (separation > 0) continue;
    ASSERT_LE(found.separation, separation + 1e-9);
    ASSERT_GE(found.separation, 1.06 * separation - 1e-9);
  }
  EXPECT_GT(met, 2000);
}

}  // namespace
}  // namespace atl::collision
