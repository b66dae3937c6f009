// A step of a scene in a steady state allocates nothing.

#include <atoll/atoll.h>
#include <gtest/gtest.h>
#include <jobs/assert.h>

#include <algorithm>
#include <new>

#include "allocation_count.h"
#include "support/bodies.h"

namespace atl::test {
namespace {

std::int64_t allocations_of(World& world, int steps) {
  const std::int64_t before = allocation_count();
  for (int i = 0; i < steps; ++i) world.step(dt);
  return allocation_count() - before;
}

// The least in so many steps. A helper thread's memory grows as it gets a larger group than it had, which on a busy
// machine may be late: then the steps after it tell.
std::int64_t min_allocations_of(World& world, int steps) {
  std::int64_t min = allocations_of(world, steps);
  for (int more = 0; world.threads() > 1 && min > 0 && more < 10; ++more) {
    min = std::min(min, allocations_of(world, steps));
  }
  return min;
}

TEST(Allocation, TheHookCounts) {
  const std::int64_t before = allocation_count();
  ::operator delete(::operator new(1));
  EXPECT_EQ(allocation_count() - before, 1);
  ::operator delete(::operator new(1, std::nothrow));  // as std::stable_sort() does
  EXPECT_EQ(allocation_count() - before, 2);
}

class SteadyState : public testing::TestWithParam<int> {
  void SetUp() override {
    if (jobs::with_asserts) GTEST_SKIP() << "checks of a whole step take memory";
  }
};

TEST_P(SteadyState, RestingBodiesOfAllShapes) {
  World world({.threads = GetParam(), .settings = {.contact_events = true}});
  world.add_body(ground());
  const std::vector<Vector3> corners = {{0.4, 0.4, -0.5}, {-0.4, 0.4, -0.5}, {0, -0.5, -0.5}, {0.1, 0, 0.6}};
  const Shape shapes[] = {Box{},
                          Sphere{},
                          Capsule{0.3, 0.4},
                          Cylinder{},
                          Cone{},
                          ConvexHull(corners),
                          Ellipsoid{{0.4, 0.3, 0.5}},
                          TaperedCapsule{{0.4, 0.3}, 0.2}};
  for (int row = 0; row < 6; ++row) {
    int column = 0;
    for (const Shape& shape : shapes) {
      world.add_body({.shape = shape, .position = {2.0 * column++, 2.0 * row, 0.51}});
      world.add_body({.shape = Box{{0.3, 0.3, 0.1}}, .position = {2.0 * column, 2.0 * row, 1.6}});
    }
  }
  run(world, 240);
  EXPECT_EQ(min_allocations_of(world, 60), 0);
}

TEST_P(SteadyState, JointsOfEverySolver) {
  for (const JointSolver solver : {JointSolver::Iterative, JointSolver::Direct}) {
    World world({.threads = GetParam(), .settings = {.joint_solver = solver}});
    BodyId before = world.add_body(static_box({0, 0, 0}, {1, 1, 1}));
    for (int i = 1; i <= 20; ++i) {
      BodyDef ball = sphere({1.0 * i, 0, 0}, 0.3);
      ball.filter.group = -1;
      const BodyId next = world.add_body(ball);
      const JointAxis angle{.range = {-0.2, 0.2}};
      world.add_joint({.kind = i % 2 == 0 ? JointKind(BallJoint{}) : JointKind(HingeJoint{angle}),
                       .first = before,
                       .second = next,
                       .frame_first = {{0.5, 0, 0}, Quaternion::Identity()},
                       .frame_second = {{-0.5, 0, 0}, Quaternion::Identity()},
                       .break_force = 1e9});
      before = next;
    }
    run(world, 240);
    EXPECT_EQ(min_allocations_of(world, 60), 0) << static_cast<int>(solver);
  }
}

// Small ones that break off it may be solved at once, which takes memory for each new order of elimination.
TEST_P(SteadyState, ALargeIslandInMotion) {
  World world({.threads = GetParam(), .settings = {.contact_solver = ContactSolver::Iterative}});
  world.add_body(static_box({0, 0, -0.5}, {20, 20, 0.5}));
  BodyDef piston = box({0, 0, 0.25}, {8, 0.2, 0.2});
  piston.type = BodyType::Kinematic;
  piston.angular_velocity = {0, 0, 1};
  world.add_body(piston);
  for (int i = 0; i < 800; ++i) {
    world.add_body(box({-4 + 1.01 * (i % 9), -4 + 1.01 * (i / 9 % 9), 1.2 + 1.01 * (i / 81)}));
  }
  run(world, 900);
  // Things still move about, so a list may still grow now and then; not in every step.
  EXPECT_LE(allocations_of(world, 120), 12);
}

INSTANTIATE_TEST_SUITE_P(Threads, SteadyState, testing::Values(1, 2));

TEST(Allocation, ASnapshotThatIsSavedAgainNeedsNone) {
  World world;
  world.add_body(ground());
  add_stack(world, 10);
  run(world, 30);
  Snapshot snapshot;
  world.save(snapshot);
  run(world, 30);
  const std::int64_t before = allocation_count();
  world.save(snapshot);
  EXPECT_EQ(allocation_count() - before, 0);
}

}  // namespace
}  // namespace atl::test
