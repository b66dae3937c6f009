// Coordinates of joints in lanes, on every instruction set: those that joint_coordinates.h has in double.

#include <gtest/gtest.h>
#include <solver/integrate/motion.h>
#include <solver/sweep/group_joints.h>

#include "joint_pose.h"
#include "joint_rig.h"
#include "support/random.h"

namespace atl::test::joint_lanes_test {
namespace {

constexpr int coordinate_count = static_cast<int>(all_coordinates.size());
constexpr double h = 1.0 / 240;

// Pairs of bodies, each joined by one coordinate, in lanes of different ones.
struct Pairs {
  JointRig rig;
  SolverBodies moved;
  SubstepConstants constants = SubstepConstants::of({}, 4 * h);
  JointGraph graph;
  GroupJoints joints;
  std::vector<BodyPose> poses;  // by body, where displacements have brought them

  Pairs(std::uint32_t seed, const Law& law) {
    Random random(seed);
    for (int i = 0; i < 3 * coordinate_count; ++i) {
      const std::uint32_t first = rig.add_dynamic(random.vector(100), 1, {0.1, 0.1, 0.1}, random.rotation());
      const std::uint32_t second =
          rig.add_dynamic(rig.bodies.position(first) + random.vector(1), 1, {0.1, 0.1, 0.1}, random.rotation());
      Joint& joint = rig.join(first, second, rig.bodies.position(first) + random.vector(1), random.rotation());
      joint.axes_second = random.rotation();
      joint.anchor_second = random.vector(1);
      joint.ratio = random.real(-2, 2);
      add_row(joint, all_coordinates[static_cast<std::size_t>(i % coordinate_count)], law);
      joint.position[0] = joint.coordinate[0] == Coordinate::Twist ? random.real(-20, 20) : random.real(-3, 3);
      joints.add({first, second, static_cast<std::uint32_t>(i), joint.point, joint.rows}, joint);
    }
    moved.reset(rig.bodies.size(), {});
    for (std::uint32_t body = 0; body < rig.bodies.size(); ++body) {
      const Quaternion turn = Quaternion(1, 0, 0, 0).slerp(random.real(0, 0.2), random.rotation());
      const Vector3 shift = random.vector(0.3);
      DisplacementRows& rows = moved.displacement[body];
      for (int k = 0; k < 4; ++k) rows.rotation[k] = static_cast<float>(turn.coeffs()[k]);
      for (int k = 0; k < 3; ++k) rows.linear[k] = static_cast<float>(shift[k]);
      poses.push_back({rig.bodies.position(body) + shift, (turn * rig.bodies.orientation(body)).normalized()});
      moved.velocity[body].inertia_xx = moved.velocity[body].inertia_yy = moved.inertia[body].zz = 10;
      moved.free_velocity[body].inverse_mass = 1;
    }
  }

  JointKernelData refresh(const Kernels& kernels) {
    joints.colour(0, static_cast<std::uint32_t>(rig.bodies.size()));
    graph.build(rig.joints, std::vector<std::uint8_t>(rig.joints.size(), 1), rig.bodies);
    const JointStep step{rig.joints.data(), &graph, rig.bodies, moved, constants, h};
    const JointKernelData data = joints.kernel_data(moved, constants, false);
    joints.prepare(step, 0, joints.block_count());
    kernels.prepare_joints(data, 0, joints.block_count());
    joints.prepare_rows(step, 0, joints.block_count());
    kernels.refresh_rows(data, false, 0, joints.block_count());
    return data;
  }
};

TEST(JointLanes, CoordinatesAreThoseInDouble) {
  const Law free = {.motor_speed = 1, .motor_force = 1}, locked = {.lower = 0, .upper = 0};
  for (const Kernels* kernels : available_kernels()) {
    for (const Law& law : {free, locked}) {
      Pairs pairs(5, law);
      const JointKernelData data = pairs.refresh(*kernels);
      int compared = 0;
      for (std::size_t b = 0; b < pairs.joints.block_count(); ++b) {
        for (std::size_t lane = 0; lane < block_lanes; ++lane) {
          if (data.blocks[b].joint[lane] < 0) continue;
          const Joint& joint = pairs.rig.joints[static_cast<std::size_t>(data.blocks[b].joint[lane])];
          const BodyPose &first = pairs.poses[joint.first], &second = pairs.poses[joint.second];
          const JointFrames frames =
              joint_frames(joint, first.position, first.orientation, second.position, second.orientation);
          const LawRow expected = law_row(joint, 0, frames, joint.position[0]);
          const JointRowBlock& row = data.rows[data.blocks[b].first_row];
          const JointCoordinateBlock& found = data.coordinates[data.blocks[b].first_row];
          const auto named = testing::Message()
                             << kernels->name << ", coordinate " << static_cast<int>(joint.coordinate[0]) << ", joint "
                             << data.blocks[b].joint[lane];
          const double near = 1e-5 * (1 + expected.at.angular_second.squaredNorm());
          const auto lane_of = [lane](const auto& rows) {
            return Vector3(rows[0][lane], rows[1][lane], rows[2][lane]);
          };
          EXPECT_LT((lane_of(row.linear) - expected.at.linear).norm(), near) << named;
          EXPECT_LT((lane_of(row.angular_first) - expected.at.angular_first).norm(), near) << named;
          EXPECT_LT((lane_of(row.angular_second) - expected.at.angular_second).norm(), near) << named;
          EXPECT_NEAR(found.base[lane] + found.value[lane], expected.at.value, near) << named;
          EXPECT_NEAR(found.base[lane] + found.position[lane], expected.position, near) << named;
          EXPECT_NEAR(found.share[lane], expected.at.share, near) << named;
          ++compared;
        }
      }
      EXPECT_EQ(compared, 3 * coordinate_count);
    }
  }
}

// A joint that is closed and has not moved has no gap, to the last bit.
TEST(JointLanes, WhatIsClosedHasNoGap) {
  Pairs pairs(7, {.lower = 0, .upper = 0});
  for (Joint& joint : pairs.rig.joints) {
    const Quaternion axes = pairs.rig.bodies.orientation(joint.first) * joint.axes_first;
    joint.axes_second = pairs.rig.bodies.orientation(joint.second).conjugate() * axes;
  }
  for (DisplacementRows& rows : pairs.moved.displacement) rows = {{0, 0, 0}, 1, {0, 0, 0, 1}};
  const JointKernelData data = pairs.refresh(*available_kernels().front());
  for (std::size_t b = 0; b < pairs.joints.block_count(); ++b) {
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      if (data.blocks[b].joint[lane] < 0) continue;
      const Joint& joint = pairs.rig.joints[static_cast<std::size_t>(data.blocks[b].joint[lane])];
      const Coordinate coordinate = joint.coordinate[0];
      if (coordinate < Coordinate::TurnX || coordinate > Coordinate::SkewZY) continue;
      EXPECT_NEAR(data.coordinates[data.blocks[b].first_row].value[lane], 0, 1e-15) << static_cast<int>(coordinate);
    }
  }
}

}  // namespace
}  // namespace atl::test::joint_lanes_test
