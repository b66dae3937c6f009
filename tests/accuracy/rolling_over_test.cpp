// A box that touches with one edge, and comes down with a corner in the same step.

#include <atoll/errors.h>
#include <atoll/world.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace atl::rolling_over_test {
namespace {

// m: the most that a bar overlaps a block which it lies on with an edge, across the block's rim, as it spins down onto
// it.
double overlap_of_bar(double tilt, double spin, double half_length) {
  const Shape block = Box{{1, 1, 0.5}}, bar = Box{{half_length, 0.25, 0.25}};
  World world({.gravity = {0, 0, 0}});
  const BodyId below = world.add_body({.type = BodyType::Static, .shape = block, .position = {0, 0, -0.5}});
  const Quaternion turn = Quaternion(Eigen::AngleAxisd(tilt, Vector3::UnitY())) *
                          Quaternion(Eigen::AngleAxisd(std::numbers::pi / 4, Vector3::UnitX()));
  const Vector3 up(std::sin(tilt), 0, std::cos(tilt));
  const BodyId above = world.add_body({.shape = bar,
                                       .position = Vector3(1, 0, 0) + (0.25 * std::sqrt(2) + 0.001) * up,
                                       .orientation = turn,
                                       .angular_velocity = {0, -spin, 0}});
  double max = 0;
  for (int i = 0; i < 3; ++i) {
    world.step(1.0 / 60);
    max = std::max(max,
                   overlap({BodyType::Static, block, world.pose(below)}, {BodyType::Dynamic, bar, world.pose(above)}));
  }
  return max;
}

// Without the corner in the contact it goes in by 20 times as much.
TEST(RollingOver, StopsWhereACornerGetsThere) {
  EXPECT_LT(overlap_of_bar(0.2, 10, 0.7), 0.01);
  EXPECT_LT(overlap_of_bar(0.2, 17, 0.7), 0.01);
  EXPECT_LT(overlap_of_bar(0.15, 14, 0.5), 0.01);
  EXPECT_LT(overlap_of_bar(0.15, 17, 0.7), 0.01);
  EXPECT_LT(overlap_of_bar(0.3, 14, 0.7), 0.01);
}

}  // namespace
}  // namespace atl::rolling_over_test
