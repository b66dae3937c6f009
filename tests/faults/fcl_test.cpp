// Faults of FCL: without its manifolds solids fall through each other, and its wrong answers are replaced and counted.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "misleading_fcl.h"

namespace atl {
namespace {

struct Case {
  const char* name;
  Shape shape;
  double rest;  // m, height at which it rests on its support
};

Shape hull_of_box(const Vector3& half) {
  std::vector<Vector3> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back(i & 1 ? -half.x() : half.x(), i & 2 ? -half.y() : half.y(), i & 4 ? -half.z() : half.z());
  }
  return ConvexHull(corners);
}

std::vector<Case> solids() {
  return {{"box", Box{.half_extents = {0.5, 0.4, 0.3}}, 0.3},
          {"sphere", Sphere{.radius = 0.4}, 0.4},
          {"hull", hull_of_box({0.5, 0.4, 0.3}), 0.3},
          {"cylinder", Cylinder{.radius = 0.5, .half_height = 0.3}, 0.3},
          {"cone", Cone{.radius = 0.5, .half_height = 0.3}, 0.3}};
}

// Solids side by side fall by 5 cm on a wide support each, with its top at 0.
class OnSupports {
 public:
  explicit OnSupports(const Shape& support, double top) {
    for (const Case& c : solids()) {
      const double x = 10.0 * static_cast<double>(bodies.size());
      world.add_body({.type = BodyType::Static, .shape = support, .position = {x, 0, -top}});
      bodies.push_back(world.add_body({.shape = c.shape, .position = {x + 0.1, 0.2, c.rest + 0.05}}));
    }
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      const StepCounts counts = world.step(1.0 / 60).counts;
      calls += counts.fcl_calls;
      repairs += counts.fcl_repairs;
    }
  }

  World world;
  std::vector<BodyId> bodies;
  std::int64_t calls = 0;
  std::int64_t repairs = 0;
};

struct Support {
  const char* name;
  Shape shape;
  double top;
};

std::vector<Support> supports() {
  return {{"box", Box{.half_extents = {3, 3, 1}}, 1}, {"hull", hull_of_box({3, 3, 1}), 1}};
}

TEST(MisleadingFcl, WithoutAnswersNothingTouches) {
  test::let_fcl_be(test::Fcl::Silent);
  for (const Support& support : supports()) {
    OnSupports scene(support.shape, support.top);
    scene.run(60);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      // A sphere and a hull are found in closed form: FCL is not asked.
      const bool closed_form = std::string(solids()[i].name) == "sphere" && std::string(support.name) == "hull";
      const double height = scene.world.pose(scene.bodies[i]).position.z();
      if (closed_form) {
        EXPECT_NEAR(height, solids()[i].rest, 0.01);
      } else {
        EXPECT_LT(height, -3) << solids()[i].name << " on a " << support.name;
      }
    }
    EXPECT_GT(scene.calls, 0);
  }
}

TEST(MisleadingFcl, TurnedNormalsAreReplacedAndCounted) {
  test::let_fcl_be(test::Fcl::Turned);
  for (const Support& support : supports()) {
    OnSupports scene(support.shape, support.top);
    scene.run(120);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Pose pose = scene.world.pose(scene.bodies[i]);
      EXPECT_NEAR(pose.position.z(), solids()[i].rest, 2e-3) << solids()[i].name << " on a " << support.name;
      EXPECT_NEAR(pose.position.x(), 10.0 * static_cast<double>(i) + 0.1, 5e-3) << solids()[i].name;
    }
    EXPECT_GE(scene.repairs, static_cast<std::int64_t>(scene.bodies.size()) - 1);
    EXPECT_GE(scene.calls, scene.repairs);
  }
}

}  // namespace
}  // namespace atl
