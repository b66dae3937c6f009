// Ellipsoids and tapered capsules among all other solids: what they come to rest in overlaps no more than what the
// others do.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/placing.h"
#include "support/random.h"

namespace atl::test::smooth_solids_rest_test {
namespace {

std::vector<Shape> solids() {
  Random random(2);
  std::vector<Vector3> points;
  for (int i = 0; i < 20; ++i) points.push_back(0.25 * random.direction());
  return {Sphere{0.2},    Capsule{0.12, 0.15}, Box{{0.2, 0.15, 0.1}},        Cylinder{0.2, 0.12},
          Cone{0.2, 0.2}, ConvexHull(points),  Ellipsoid{{0.25, 0.2, 0.12}}, TaperedCapsule{{0.18, 0.1}, 0.15}};
}

bool is_smooth(const Shape& shape) {
  return std::holds_alternative<Ellipsoid>(shape) || std::holds_alternative<TaperedCapsule>(shape);
}

// A pit with sides of 1 m.
void add_pit(World& world) {
  world.add_body(ground());
  for (const double side : {-1.0, 1.0}) {
    world.add_body(static_box({side * 1.5, 0, 2}, {0.5, 2, 2}));
    world.add_body(static_box({0, side * 1.5, 2}, {1, 0.5, 2}));
  }
}

TEST(SmoothSolidsRest, AmongAllOthers) {
  const std::vector<Shape> shapes = solids();
  double smooth_overlap = 0, other_overlap = 0;
  int touching = 0;
  for (std::uint64_t seed = 1; seed <= 7; ++seed) {
    World world;
    add_pit(world);
    Random random(seed);
    std::vector<BodyId> ids;
    for (int i = 0; i < 48; ++i) {
      const Vector3 place(random.real(-0.6, 0.6), random.real(-0.6, 0.6), 0.4 + 0.25 * i);
      ids.push_back(world.add_body({.shape = shapes[static_cast<std::size_t>(i) % shapes.size()],
                                    .position = place,
                                    .orientation = random.rotation(),
                                    .material = {.rolling_friction = 0.002}}));
    }
    run(world, 900);
    std::vector<PlacedShape> placed;
    for (const BodyId id : ids) {
      const Pose pose = world.pose(id);
      placed.push_back(place(shapes[placed.size() % shapes.size()], pose.position, pose.orientation));
      EXPECT_LT(world.velocity(id).norm(), 0.02) << "seed " << seed;
    }
    for (std::size_t i = 0; i < placed.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if ((placed[i].pose.position - placed[j].pose.position).norm() > 0.8) continue;
        const bool smooth = is_smooth(placed[i].shape) || is_smooth(placed[j].shape);
        const double depth = overlap(placed[i], placed[j]);
        touching += smooth && depth > 0;
        (smooth ? smooth_overlap : other_overlap) = std::max(smooth ? smooth_overlap : other_overlap, depth);
      }
    }
  }
  EXPECT_GT(touching, 200);
  EXPECT_LE(smooth_overlap, 1.2 * other_overlap);
}

}  // namespace
}  // namespace atl::test::smooth_solids_rest_test
