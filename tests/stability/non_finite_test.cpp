// A body whose state would overflow is reported by its index, in the step in which it happens; the rest goes on.

#include <atoll/atoll.h>
#include <gtest/gtest.h>

#include "support/bodies.h"

namespace atl::test {
namespace {

TEST(NonFinite, LowestBodyIsReportedInTheStepThatLosesIt) {
  World world;
  world.add_body(ground());
  const BodyId crate = world.add_body(box({0, 0, 0.5}));
  const BodyId first = world.add_body(box({5, 0, 0.5}));
  const BodyId second = world.add_body(box({10, 0, 0.5}));
  const BodyId third = world.add_body(box({15, 0, 0.5}));
  EXPECT_EQ(world.step(dt).first_quarantined, -1);

  world.apply_force(second, {1e300, 0, 0});
  world.apply_force(first, {0, 0, 1e300});
  EXPECT_EQ(world.step(dt).first_quarantined, first.index);
  EXPECT_EQ(world.step(dt).first_quarantined, -1);
  world.apply_force(third, {1e300, 0, 0});
  EXPECT_EQ(world.step(dt).first_quarantined, third.index);
  world.remove_body(first);
  for (int i = 0; i < 60; ++i) EXPECT_EQ(world.step(dt).first_quarantined, -1);
  EXPECT_NEAR(world.pose(crate).position.z(), 0.5, 1e-3);
}

}  // namespace
}  // namespace atl::test
