// Rings of boxes with more joints than they need, consistent and at rest: nothing may move.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "support/bodies.h"

namespace atl::test::rings_test {
namespace {

constexpr std::size_t boxes_of_ring = 12;

// Each box is joined to those that are `offsets` ahead of it, halfway.
World ring(const JointKind& kind, const std::vector<std::size_t>& offsets, JointSolver solver) {
  World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}});
  std::vector<BodyId> boxes;
  for (std::size_t i = 0; i < boxes_of_ring; ++i) {
    const double turn = static_cast<double>(i) * 2 * std::numbers::pi / boxes_of_ring;
    boxes.push_back(world.add_body(box({2 * std::cos(turn), 2 * std::sin(turn), 5}, Vector3::Constant(0.2))));
  }
  for (std::size_t i = 0; i < boxes_of_ring; ++i) {
    for (const std::size_t offset : offsets) {
      const BodyId first = boxes[i], second = boxes[(i + offset) % boxes_of_ring];
      const Vector3 middle = (world.pose(first).position + world.pose(second).position) / 2;
      world.add_joint(joint_at(world, kind, first, second, middle, Vector3::UnitX()));
    }
  }
  return world;
}

TEST(Rings, StayAtRest) {
  for (const JointSolver solver : {JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative}) {
    for (const JointKind& kind : {JointKind(FixedJoint{}), JointKind(BallJoint{}), JointKind(HingeJoint{})}) {
      for (const std::vector<std::size_t>& offsets :
           {std::vector<std::size_t>{1, 1}, std::vector<std::size_t>{1, 1, 1}, std::vector<std::size_t>{1, 2, 3, 5}}) {
        World world = ring(kind, offsets, solver);
        double fastest = 0;
        for (int step = 0; step < 300; ++step) {
          ASSERT_EQ(world.step(dt).quarantined, 0);
          for (const BodyId id : world.bodies()) fastest = std::max(fastest, world.velocity(id).norm());
        }
        EXPECT_LT(fastest, 1e-9) << kind.index() << ", " << offsets.size() << " joints a box";
      }
    }
  }
}

}  // namespace
}  // namespace atl::test::rings_test
