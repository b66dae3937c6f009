// Effects of the rows of joints on the momentum of the two bodies, and their power.

#include <gtest/gtest.h>

#include "joint_pose.h"

namespace atl::solver {
namespace {

using Vector3 = Eigen::Vector3d;
using test::JointPose;
using test::Random;

class JointRows : public testing::TestWithParam<Coordinate> {};

bool is_gear(Coordinate coordinate) { return coordinate == Coordinate::Gear || coordinate == Coordinate::Rack; }

// An impulse along the row acts on both bodies oppositely, so their linear momentum stays; the angular one, about any
// point, does if the force has no lever left: (x_B - x_A) x linear + angular_second - angular_first = 0. Gears alone
// take the rest from what carries them.
TEST_P(JointRows, ConserveMomentum) {
  Random random(21);
  for (int i = 0; i < 1000; ++i) {
    const JointPose pose(random, GetParam());
    const JointRow row = pose.row();
    const Vector3 apart = pose.second.position - pose.first.position;
    const Vector3 left = apart.cross(row.linear) + row.angular_second - row.angular_first;
    if (is_gear(GetParam())) {
      EXPECT_GT(left.norm(), 0);
    } else {
      const double size = row.linear.norm() * apart.norm() + row.angular_first.norm() + row.angular_second.norm();
      ASSERT_LT(left.norm(), 1e-14 * size) << "pose " << i;
    }
  }
}

// The same said of velocities: whatever both bodies do together, as one, no coordinate changes.
TEST_P(JointRows, IgnoreCommonMotion) {
  if (is_gear(GetParam())) return;
  Random random(22);
  for (int i = 0; i < 1000; ++i) {
    JointPose pose(random, GetParam());
    const Vector3 velocity = random.vector(2), spin = random.vector(2);
    for (JointPose::Body* body : {&pose.first, &pose.second}) {
      body->velocity = velocity + spin.cross(body->position);
      body->spin = spin;
    }
    const JointRow row = pose.row();
    ASSERT_NEAR(pose.rate(), 0, 1e-13 * (1 + row.angular_first.norm() + row.angular_second.norm())) << "pose " << i;
  }
}

// No row is zero, so each has an effective mass.
TEST_P(JointRows, AreNeverZero) {
  Random random(23);
  for (int i = 0; i < 1000; ++i) {
    const JointRow row = JointPose(random, GetParam()).row();
    EXPECT_GT(row.linear.norm() + row.angular_first.norm() + row.angular_second.norm(), 1e-6) << "pose " << i;
    EXPECT_TRUE(row.linear.allFinite() && row.angular_first.allFinite() && row.angular_second.allFinite());
  }
}

INSTANTIATE_TEST_SUITE_P(Coordinates, JointRows, testing::ValuesIn(test::all_coordinates));

}  // namespace
}  // namespace atl::solver
