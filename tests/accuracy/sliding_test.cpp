// A block that slides to rest under Coulomb friction: straight on, over v^2 / (2 mu g), whatever its heading.
//
// Positions are exact while the block brakes steadily. The substep in which it stops is off by at most mu g h^2, and
// the normal force, and friction with it, is off while the contact takes up the load: by a part of the first substep.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/bodies.h"

namespace atl::test::sliding_test {
namespace {

constexpr double friction = 0.5;
constexpr double speed = 5;
const double path = speed * speed / (2 * friction * g);

struct Slide {
  double forward;  ///< m, along the heading
  double lateral;  ///< m, to the left of it
  double end_speed;
};

Slide slide(double heading, const Settings& settings) {
  World world({.settings = settings});
  world.add_body(ground(friction));
  const Vector3 forward(std::cos(heading), std::sin(heading), 0);
  BodyDef def = box({0, 0, 0.5});
  def.velocity = speed * forward;
  def.material.friction = friction;
  const BodyId block = world.add_body(def);
  const double time_to_stop = speed / (friction * g);
  run(world, static_cast<int>((time_to_stop + 0.5) / dt));

  const Vector3 moved = world.pose(block).position - def.position;
  return {
      .forward = moved.dot(forward), .lateral = forward.cross(moved).z(), .end_speed = world.velocity(block).norm()};
}

double heading(int index) { return index * std::numbers::pi / 6; }

TEST(Sliding, BlockStopsAfterTheClosedFormsPathOnTwelveHeadings) {
  for (const int substeps : {4, 16}) {
    const Settings settings = {.substeps = substeps};
    for (int i = 0; i < 12; ++i) {
      SCOPED_TRACE("substeps " + std::to_string(substeps) + ", heading " + std::to_string(30 * i));
      const Slide end = slide(heading(i), settings);
      EXPECT_NEAR(end.forward, path, 1e-4 * path);
      EXPECT_LT(std::abs(end.lateral), 1e-4 * path);
      EXPECT_LT(end.end_speed, 1e-4 * speed);
    }
  }
}

TEST(Sliding, FrictionPyramidBendsThePathOffItsAxes) {
  // Each tangential component is braked by mu g alone and stops alone, so at an angle a to the pyramid's axes the
  // block ends at path * (cos^2 a, sin^2 a): beside its heading by path * cos a sin a |sin a - cos a|. Whichever way
  // the axes lie, of headings 30 degrees apart one is off by at least 0.15 path.
  const Settings settings = {.friction = FrictionModel::Pyramid};
  double worst = 0;
  for (int i = 0; i < 12; ++i) worst = std::max(worst, std::abs(slide(heading(i), settings).lateral));
  EXPECT_GT(worst, 0.15 * path);
  EXPECT_LT(worst, 0.18 * path) << "the closed form's largest value is 0.177";
}

TEST(Sliding, FrictionActsAgainstTheMotionWithMuTimesTheNormalForce) {
  for (int i = 0; i < 12; ++i) {
    World world;
    const BodyId plane = world.add_body(ground(friction));
    const Vector3 forward(std::cos(heading(i)), std::sin(heading(i)), 0);
    BodyDef def = box({0, 0, 0.5});
    def.velocity = speed * forward;
    def.material.friction = friction;
    const BodyId block = world.add_body(def);
    run(world, 30);

    const Vector3 force = contact_force(world, plane, block);
    const Vector3 tangential(force.x(), force.y(), 0);
    EXPECT_NEAR(tangential.norm(), friction * force.z(), 0.005 * friction * force.z());
    EXPECT_NEAR(tangential.dot(forward), -tangential.norm(), 1e-4 * tangential.norm());
  }
}

TEST(Sliding, FrictionOfAPairIsTheGeometricMean) {
  for (const auto& [of_ground, of_block] : {std::pair{0.25, 1.0}, {0.9, 0.4}, {0.0, 1.0}}) {
    World world;
    world.add_body(ground(of_ground));
    BodyDef def = box({0, 0, 0.5});
    def.velocity = {speed, 0, 0};
    def.material.friction = of_block;
    const BodyId block = world.add_body(def);
    const int steps = 30;
    run(world, steps);
    const double deceleration = std::sqrt(of_ground * of_block) * g;
    EXPECT_NEAR(world.velocity(block).x(), speed - deceleration * steps * dt, deceleration * substep() + 1e-5);
  }
}

}  // namespace
}  // namespace atl::test::sliding_test
