// The same stack far from the origin, and small and large: a double holds 1e6 m to 1e-10 m, and solver arithmetic is on
// changes within a step, so distance costs nothing.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/scene_run.h"

namespace atl::test {
namespace {

/// Poses of a stack of five after five seconds, relative to where it was built.
std::vector<Pose> stack_at(const Vector3& base) {
  World world;
  world.add_body({.type = BodyType::Static, .shape = HalfSpace{}, .position = base});
  const std::vector<BodyId> ids = add_stack(world, 5, base);
  run_finite(world, 300);
  std::vector<Pose> poses;
  for (BodyId id : ids) {
    poses.push_back(world.pose(id));
    poses.back().position -= base;
  }
  return poses;
}

TEST(Scale, StackFarFromTheOriginStandsAsAtTheOrigin) {
  const std::vector<Pose> near = stack_at({0, 0, 0});
  for (const Vector3& base : {Vector3(1e6, 0, 0), Vector3(-1e6, 1e6, 1e6)}) {
    const std::vector<Pose> far = stack_at(base);
    for (std::size_t i = 0; i < near.size(); ++i) {
      EXPECT_LT((far[i].position - near[i].position).norm(), 1e-3) << i;
      EXPECT_LT(far[i].orientation.angularDistance(near[i].orientation), 1e-3) << i;
    }
  }
}

/// The place where a box dropped on another ends, from the lower one's centre.
Vector3 landing_at(const Vector3& base) {
  World world;
  world.add_body(static_box(base, {5, 5, 0.5}));
  const BodyId crate = world.add_body(box(base + Vector3(0.3, 0.2, 2)));
  run_finite(world, 180);
  return world.pose(crate).position - base;
}

TEST(Scale, BoxDroppedFarFromTheOriginLandsAsAtTheOrigin) {
  const Vector3 near = landing_at(Vector3::Zero());
  // It may slide a little as it lands: its four corners take up the impact one after the other.
  EXPECT_LT((near - Vector3(0.3, 0.2, 1)).norm(), 5e-3);
  EXPECT_LT((landing_at({1e6, -1e6, 0}) - near).norm(), 1e-3);
}

/// Sizes are edges in m. The soft contact's give is a length that does not scale with the boxes.
TEST(Scale, StacksOfSmallAndLargeBoxesStand) {
  for (const double size : {0.01, 0.1, 10.0, 100.0}) {
    World world;
    world.add_body(ground());
    const std::vector<BodyId> ids = add_stack(world, 3, Vector3::Zero(), size);
    run_finite(world, 300);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      SCOPED_TRACE("size " + std::to_string(size) + ", box " + std::to_string(i));
      const Vector3 position = world.pose(ids[i]).position;
      EXPECT_LT(position.head<2>().norm(), 0.02 * size);
      EXPECT_NEAR(position.z(), (static_cast<double>(i) + 0.5) * size, std::max(0.002 * size, 3e-3));
      EXPECT_LT(tilt(world, ids[i]), 0.02);
    }
  }
}

// Chains of needles as slender as 1 to a million, whose moments differ by up to 5e11. One joint in two is a hinge, so
// that the spin of needles about themselves counts.
TEST(Scale, NeedlesHangOnJoints) {
  for (const double ratio : {1e2, 1e3, 1e4, 1e5, 1e6}) {
    for (const JointSolver solver : {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct}) {
      World world({.settings = {.joint_solver = solver}});
      std::vector<BodyId> chain = {world.add_body(static_box({0, 0, 0}, Vector3::Constant(0.1)))};
      for (int i = 0; i < 4; ++i) {
        BodyDef def = box({0.5 + i, 0, 0}, {0.5, 0.5 / ratio, 0.5 / ratio});
        def.mass = 1;
        def.orientation = Eigen::AngleAxisd(0.6 * (i % 2), Vector3::UnitX());
        chain.push_back(world.add_body(def));
        const JointKind kind = i % 2 == 0 ? JointKind(BallJoint{}) : JointKind(HingeJoint{});
        world.add_joint(joint_at(world, kind, chain.end()[-2], chain.back(), {1.0 * i, 0, 0}, Vector3::UnitX()));
      }
      double gap = 0;
      for (int i = 0; i < 600; ++i) {
        world.step(dt);
        for (std::size_t k = 1; k < chain.size(); ++k) {
          const Pose above = world.pose(chain[k - 1]), below = world.pose(chain[k]);
          const Vector3 end = above.position + above.orientation * Vector3(k > 1 ? 0.5 : 0, 0, 0);
          gap = std::max(gap, (end - below.position - below.orientation * Vector3(-0.5, 0, 0)).norm());
        }
      }
      EXPECT_TRUE(world.quarantined().empty()) << "1:" << ratio;
      EXPECT_LT(gap, solver == JointSolver::Iterative ? 0.01 : 1e-8) << "1:" << ratio;
    }
  }
}

TEST(Scale, DensityDoesNotMatterToAStackOfOneMaterial) {
  std::vector<double> heights;
  for (const double density : {1.0, 1000.0, 20000.0}) {
    World world;
    world.add_body(ground());
    std::vector<BodyId> ids;
    for (int i = 0; i < 5; ++i) {
      BodyDef def = box({0, 0, i + 0.5});
      def.density = density;
      ids.push_back(world.add_body(def));
    }
    run_finite(world, 180);
    heights.push_back(world.pose(ids.back()).position.z());
  }
  EXPECT_NEAR(heights[0], heights[1], 1e-5);
  EXPECT_NEAR(heights[2], heights[1], 1e-5);
}

}  // namespace
}  // namespace atl::test
