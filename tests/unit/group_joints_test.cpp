// Joints that are solved one after another: against dense algebra, closed forms and conservation, and against
// themselves on every instruction set, bit for bit.

#include <gtest/gtest.h>
#include <solver/constraints/spring_step.h>

#include <Eigen/Dense>
#include <cstring>
#include <set>

#include "joint_rig.h"
#include "support/bodies.h"
#include "support/random.h"

namespace atl::test {
namespace {

// Islands of a few bodies each, with joints of all kinds and all laws between them, to the ground and to a kinematic
// body.
JointRig random_rig(std::uint32_t seed) {
  Random random(seed);
  JointRig rig;
  rig.gravity = {0, 0, -9.81};
  const std::uint32_t ground = rig.add_fixed({1, 2, 3});
  const std::uint32_t moving = rig.add_kinematic({5, 5, 5}, {0.5, 0, 0.1}, {0, 0.7, 0});
  for (int island = 0; island < 12; ++island) {
    const Vector3 place = random.vector(10);
    std::vector<std::uint32_t> own;
    for (int i = 0; i < 5; ++i) {
      const Vector3 moments(random.real(0.05, 0.1), random.real(0.05, 0.1), random.real(0.05, 0.1));
      own.push_back(rig.add_dynamic(place + random.vector(1), random.real(0.5, 2), moments, random.rotation()));
      rig.bodies.velocity(own.back()) = random.vector(2);
      rig.bodies.angular_velocity(own.back()) = random.vector(4);
    }
    const std::uint32_t others[] = {ground, moving, own[4]};
    for (std::size_t i = 0; i < own.size(); ++i) {
      const std::uint32_t other = i == 0 ? others[random.below(3)] : own[i - 1];
      const Vector3 at = 0.5 * (rig.bodies.position(own[i]) + rig.bodies.position(other)) + random.vector(0.1);
      Joint& joint = random.chance(0.5) ? rig.join(other, own[i], at, random.rotation())
                                        : rig.join(own[i], other, at, random.rotation());
      joint.point = random.chance(0.7);
      const Law laws[] = {locked_law,
                          {.lower = -0.1, .upper = 0.2},
                          {.spring_hertz = 3, .damping_ratio = 0.5, .rest = 0.1},
                          {.motor_speed = 2, .motor_force = 5},
                          {.lower = -0.2, .spring_hertz = 5, .motor_speed = -1, .motor_force = 2}};
      const Coordinate angular[] = {Coordinate::TurnX, Coordinate::SwingAlongY, Coordinate::AngleX,
                                    Coordinate::SpinZ, Coordinate::Twist,       Coordinate::Gear};
      const Coordinate linear[] = {Coordinate::OffsetX, Coordinate::OffsetY, Coordinate::Distance, Coordinate::Rack};
      const std::uint32_t rows = random.below(4);
      for (std::uint32_t r = 0; r < rows; ++r) add_row(joint, angular[random.below(6)], laws[random.below(5)]);
      if (!joint.point) add_row(joint, linear[random.below(4)], laws[random.below(5)]);
    }
  }
  return rig;
}

void expect_same_bits(const JointRig& a, const JointRig& b) {
  const auto expect_equal = [](std::span<const double> x, std::span<const double> y) {
    ASSERT_EQ(x.size(), y.size());
    EXPECT_EQ(std::memcmp(x.data(), y.data(), x.size() * sizeof(double)), 0);
  };
  expect_equal(a.bodies.positions, b.bodies.positions);
  expect_equal(a.bodies.orientations, b.bodies.orientations);
  expect_equal(a.bodies.velocities, b.bodies.velocities);
  expect_equal(a.bodies.angular_velocities, b.bodies.angular_velocities);
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    const Joint& x = a.joints[i];
    const Joint& y = b.joints[i];
    EXPECT_EQ(std::memcmp(&x.point_impulse, &y.point_impulse, sizeof x.point_impulse), 0);
    EXPECT_EQ(std::memcmp(&x.impulse, &y.impulse, sizeof x.impulse), 0);
    EXPECT_EQ(std::memcmp(&x.position, &y.position, sizeof x.position), 0);
    EXPECT_EQ(std::memcmp(&x.force, &y.force, sizeof x.force), 0);
    EXPECT_EQ(std::memcmp(&x.torque, &y.torque, sizeof x.torque), 0);
    EXPECT_EQ(x.limit, y.limit);
  }
}

TEST(GroupJoints, SameBitsOnEachInstructionSetTeamAndGrouping) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    JointRig reference = random_rig(seed);
    reference.step(dt, 30);
    for (std::size_t i = 0; i < 3 * reference.bodies.size(); ++i) {
      ASSERT_TRUE(std::isfinite(reference.bodies.positions[i]));
    }
    for (const Kernels* kernels : available_kernels()) {
      SCOPED_TRACE(kernels->name);
      JointRig other = random_rig(seed);
      other.kernels = kernels;
      other.step(dt, 30);
      expect_same_bits(reference, other);
    }
    for (const int team : {1, 3}) {
      SCOPED_TRACE(team);
      JointRig other = random_rig(seed);
      other.team = team;
      other.step(dt, 30);
      expect_same_bits(reference, other);
    }
    JointRig apart = random_rig(seed);
    apart.one_each = true;
    apart.step(dt, 30);
    expect_same_bits(reference, apart);
  }
}

TEST(GroupJoints, BlocksOfAColourShareNoBodyAndKindsDoNotMix) {
  Random random(7);
  std::vector<LocalJoint> joints;
  for (std::uint32_t i = 0; i < 400; ++i) {
    const std::uint32_t a = random.below(100);
    const std::uint32_t b = random.below(100);
    if (a == b || std::max(a, b) < 2) continue;
    const bool point = random.chance(0.5);
    joints.push_back({a, b, i, point, static_cast<std::uint8_t>(point ? random.below(4) : 1 + random.below(6))});
  }
  Colouring colouring;
  std::vector<JointBlock> blocks;
  colouring.build(joints, 2, 100, blocks);
  std::set<std::int32_t> placed;
  std::uint32_t rows = 0;
  for (const Colour& colour : colouring.colours()) {
    std::set<std::int32_t> bodies;
    for (std::size_t b = colour.begin_block; b < colour.end_block; ++b) {
      const JointBlock& block = blocks[b];
      EXPECT_EQ(block.first_row, rows);
      rows += block.rows;
      int most = 0;
      for (std::size_t lane = 0; lane < block_lanes; ++lane) {
        if (block.joint[lane] < 0) continue;
        EXPECT_TRUE(placed.insert(block.joint[lane]).second);
        const auto joint = std::find_if(joints.begin(), joints.end(), [&](const LocalJoint& j) {
          return j.joint == static_cast<std::uint32_t>(block.joint[lane]);
        });
        EXPECT_EQ(joint->point, block.point != 0);
        EXPECT_EQ(joint->rows > 0, block.rows > 0);
        most = std::max<int>(most, joint->rows);
        for (const std::int32_t body : {block.first[lane], block.second[lane]}) {
          if (body >= 2) {
            EXPECT_TRUE(bodies.insert(body).second);
          }
        }
      }
      EXPECT_EQ(most, block.rows);
    }
  }
  EXPECT_EQ(placed.size(), joints.size());
}

// Many relaxing sweeps are the projection of the velocities onto those that the joints allow, which leaves the least
// kinetic energy in the difference. In so short a step that nothing moves.
TEST(GroupJoints, SweepsConvergeToTheDenseSolution) {
  Random random(11);
  JointRig rig;
  rig.settings = {.substeps = 1, .iterations = 1, .relax_iterations = 400, .joint_method = JointMethod::Iterative};
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  std::vector<std::uint32_t> body;
  for (int i = 0; i < 4; ++i) {
    body.push_back(rig.add_dynamic(Vector3(i + 0.5, 0, 0) + random.vector(0.1), random.real(0.5, 2),
                                   {random.real(0.1, 0.2), random.real(0.1, 0.2), random.real(0.1, 0.2)},
                                   random.rotation()));
    rig.bodies.velocity(body.back()) = random.vector(1);
    rig.bodies.angular_velocity(body.back()) = random.vector(1);
  }
  rig.join_point(ground, body[0], {0, 0, 0});
  for (std::size_t i = 0; i + 1 < body.size(); ++i) rig.join_point(body[i], body[i + 1], Vector3(i + 1.0, 0.1, 0));
  add_hinge_rows(rig.joints[1], {});
  add_row(rig.joints[2], Coordinate::TurnY, locked_law);
  rig.join(ground, body[3], {4, 0, 0});
  add_row(rig.joints[4], Coordinate::OffsetZ, locked_law);

  Eigen::MatrixXd j(0, 24);
  const auto add = [&](const Joint& joint, const JointRow& row) {
    j.conservativeResize(j.rows() + 1, 24);
    j.row(j.rows() - 1).setZero();
    if (joint.first != ground) {
      j.block<1, 3>(j.rows() - 1, 6 * (joint.first - 1)) = -row.linear.transpose();
      j.block<1, 3>(j.rows() - 1, 6 * (joint.first - 1) + 3) = -row.angular_first.transpose();
    }
    j.block<1, 3>(j.rows() - 1, 6 * (joint.second - 1)) = row.linear.transpose();
    j.block<1, 3>(j.rows() - 1, 6 * (joint.second - 1) + 3) = row.angular_second.transpose();
  };
  for (const Joint& joint : rig.joints) {
    const JointFrames frames = rig.frames(joint);
    for (int axis = 0; joint.point && axis < 3; ++axis) {
      const Vector3 unit = Vector3::Unit(axis);
      add(joint, {unit, frames.arm_first.cross(unit), frames.arm_second.cross(unit), 0});
    }
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (joint.law[r].locked()) add(joint, joint_row(joint, r, frames));
    }
  }
  Eigen::VectorXd v(24);
  Eigen::MatrixXd inverse_mass = Eigen::MatrixXd::Zero(24, 24);
  for (std::uint32_t i = 0; i < 4; ++i) {
    v.segment<3>(6 * i) = rig.bodies.velocity(i + 1);
    v.segment<3>(6 * i + 3) = rig.bodies.angular_velocity(i + 1);
    inverse_mass.block<3, 3>(6 * i, 6 * i) = rig.bodies.inverse_mass[i + 1] * Matrix3::Identity();
    const Matrix3 rotation = rig.bodies.orientation(i + 1).toRotationMatrix();
    inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) =
        rotation * rig.bodies.inverse_inertia[i + 1] * rotation.transpose();
  }
  const Eigen::VectorXd impulse = (j * inverse_mass * j.transpose()).ldlt().solve(-j * v);
  const Eigen::VectorXd expected = v + inverse_mass * j.transpose() * impulse;

  rig.step(1e-5);
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_LT((rig.bodies.velocity(i + 1) - expected.segment<3>(6 * i)).norm(), 2e-4);
    EXPECT_LT((rig.bodies.angular_velocity(i + 1) - expected.segment<3>(6 * i + 3)).norm(), 2e-4);
  }
}

TEST(GroupJoints, PointOfTwoBodiesIsSolvedAtOnce) {
  JointRig rig;
  const std::uint32_t a = rig.add_ball({0, 0, 0}, 1);
  const std::uint32_t b = rig.add_ball({1, 0, 0}, 7);
  rig.bodies.velocity(a) = Vector3(1, 2, 3);
  rig.bodies.angular_velocity(b) = Vector3(-3, 1, 2);
  const Joint& joint = rig.join_point(a, b, {0.4, 0.2, 0});
  rig.step(dt);
  EXPECT_LT(rig.point_speed(joint).norm(), 2e-6);
  EXPECT_LT(rig.frames(joint).offset.norm(), 2e-3);
}

// The joints' own impulses change neither momentum. A chain of balls that flails.
TEST(GroupJoints, KeepMomentum) {
  Random random(3);
  JointRig rig;
  std::vector<std::uint32_t> body;
  for (int i = 0; i < 6; ++i) {
    body.push_back(rig.add_ball(Vector3(i, 0, 0), random.real(0.5, 2)));
    rig.bodies.velocity(body.back()) = random.vector(2);
  }
  for (std::size_t i = 0; i + 1 < body.size(); ++i) {
    Joint& joint = rig.join_point(body[i], body[i + 1], Vector3(i + 0.5, 0, 0));
    if (i == 1) add_hinge_rows(joint, {.spring_hertz = 2});
  }
  const auto momentum = [&] {
    Vector3 sum = Vector3::Zero();
    for (const std::uint32_t i : body) sum += rig.bodies.velocity(i) / rig.bodies.inverse_mass[i];
    return sum;
  };
  const auto angular_momentum = [&] {
    Vector3 sum = Vector3::Zero();
    for (const std::uint32_t i : body) {
      sum += rig.bodies.position(i).cross(rig.bodies.velocity(i)) / rig.bodies.inverse_mass[i] +
             rig.bodies.inertia[i] * rig.bodies.angular_velocity(i);
    }
    return sum;
  };
  const Vector3 p = momentum();
  const Vector3 l = angular_momentum();
  rig.step(dt, 240);
  EXPECT_LT((momentum() - p).norm(), 1e-5 * p.norm());
  EXPECT_LT((angular_momentum() - l).norm(), 1e-3 * l.norm());
}

// Two balls on a rod through their centres that spins: it goes on.
TEST(GroupJoints, KeepASpinningPairSpinning) {
  JointRig rig;
  const std::uint32_t a = rig.add_ball({-0.5, 0, 0});
  const std::uint32_t b = rig.add_ball({0.5, 0, 0});
  rig.bodies.velocity(a) = Vector3(0, -2, 0);
  rig.bodies.velocity(b) = Vector3(0, 2, 0);
  for (const std::uint32_t body : {a, b}) rig.bodies.angular_velocity(body) = Vector3(0, 0, 4);
  rig.join_point(a, b, {0, 0, 0});
  const auto spin = [&] {
    return (rig.bodies.position(b) - rig.bodies.position(a))
                   .cross(rig.bodies.velocity(b) - rig.bodies.velocity(a))
                   .z() /
               2 +
           0.1 * (rig.bodies.angular_velocity(a) + rig.bodies.angular_velocity(b)).z();
  };
  const double start = spin();
  rig.step(dt, 600);
  EXPECT_NEAR(spin(), start, 0.002 * start);
}

// A spring moves by the map of a single body on it, for any w h.
TEST(GroupJoints, SpringIsItsMap) {
  for (const int substeps : {1, 4}) {
    for (const double wh : {0.01, 0.1, 1.0, 10.0, 1000.0}) {
      SCOPED_TRACE(wh);
      const double h = dt / substeps;
      const double zeta = 0.3;
      JointRig rig;
      rig.settings.substeps = substeps;
      const std::uint32_t ground = rig.add_fixed({0, 0, 0});
      const std::uint32_t ball = rig.add_ball({0, 0, 0}, 3);
      add_row(rig.join(ground, ball, {0, 0, 0}), Coordinate::OffsetX,
              {.spring_hertz = wh / h / (2 * 3.14159265358979323846), .damping_ratio = zeta, .rest = 0.05});
      const SpringStep map = SpringStep::of(wh / h, 2 * zeta * wh / h, h);
      double x = 0;
      double u = 0;
      for (int i = 0; i < 40; ++i) {
        rig.step(dt);
        for (int s = 0; s < substeps; ++s) {
          u = (u + map.keep * u - map.pull * (x - 0.05)) / (1 + map.hold);
          x += h * u;
        }
        ASSERT_NEAR(rig.bodies.position(ball).x(), x, 4e-6) << i;
        ASSERT_NEAR(rig.bodies.velocity(ball).x(), u, 1e-4 + 1e-5 * std::min(wh, 1.0) / h) << i;
        ASSERT_NEAR(rig.joints[0].position[0], x, 4e-6);
      }
    }
  }
}

TEST(GroupJoints, MotorPushesWithItsForceUpToItsSpeed) {
  JointRig rig;
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t ball = rig.add_ball({0, 0, 0}, 2);
  const Joint& joint = rig.join(ground, ball, {0, 0, 0});
  add_row(rig.joints[0], Coordinate::OffsetX, {.motor_speed = 3, .motor_force = 10});
  for (int i = 1; i <= 60; ++i) {
    rig.step(dt);
    EXPECT_NEAR(rig.bodies.velocity(ball).x(), std::min(3.0, 10.0 / 2 * i * dt), 1e-5);
    EXPECT_LE(std::abs(joint.force.x()), 10 * (1 + 1e-6));
  }
  EXPECT_NEAR(joint.force.x(), 0, 1e-3);
  // Nor can it hold more than its force: dragged along by a weight it brakes with all of it.
  rig.gravity = {-20, 0, 0};
  rig.step(dt, 60);
  EXPECT_NEAR(joint.force.x(), 10, 1e-4);
  EXPECT_NEAR(rig.bodies.velocity(ball).x(), 3 - 15, 1e-3);
}

TEST(GroupJoints, UnlimitedMotorReachesItsSpeedInAStep) {
  JointRig rig;
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t ball = rig.add_ball({0, 0, 0}, 2);
  Joint& joint = rig.join_point(ground, ball, {0, 0, 0});
  add_hinge_rows(joint, {.motor_speed = 10, .motor_force = Law::unlimited});
  rig.step(dt);
  EXPECT_NEAR(rig.rate(joint, 2), 10, 0.01);
  rig.step(dt, 119);
  // It counts turns: three of them by now.
  EXPECT_NEAR(joint.position[2], 20, 0.1);
  EXPECT_LT(rig.frames(joint).offset.norm(), 5e-3);
}

TEST(GroupJoints, LimitStopsWhatFallsOntoItAndNoMore) {
  JointRig rig;
  rig.gravity = {0, 0, -10};
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t ball = rig.add_ball({0, 0, 0}, 2);
  const Joint& joint = rig.join(ground, ball, {0, 0, 0});
  add_row(rig.joints[0], Coordinate::OffsetZ, {.lower = -0.5, .upper = 0.2});
  bool reached = false;
  for (int i = 0; i < 120; ++i) {
    rig.step(dt);
    EXPECT_GT(joint.position[0], -0.5 - 1e-4);
    reached |= joint.limit[0] == -1;
    if (!reached) continue;
    EXPECT_EQ(joint.limit[0], -1);
    EXPECT_NEAR(rig.bodies.velocity(ball).z(), 0, 0.05);
  }
  EXPECT_TRUE(reached);
  EXPECT_NEAR(joint.force.z(), 20, 0.01);
  rig.gravity = {0, 0, 10};
  rig.step(dt, 120);
  EXPECT_NEAR(joint.position[0], 0.2, 1e-4);
  EXPECT_EQ(joint.limit[0], 1);
  EXPECT_NEAR(joint.force.z(), -20, 0.01);
}

TEST(GroupJoints, ExceededLimitIsWonBackSlowly) {
  JointRig rig;
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t ball = rig.add_ball({0, 0, 0}, 2);
  const Joint& joint = rig.join(ground, ball, {0, 0, 0});
  add_row(rig.joints[0], Coordinate::OffsetX, {.lower = 0.3});
  double before = 0;
  for (int i = 0; i < 60; ++i) {
    rig.step(dt);
    EXPECT_GE(joint.position[0], before - 1e-6);
    EXPECT_LE(joint.position[0] - before, rig.settings.contact_push_speed * dt + 1e-6);
    // The push is no velocity that stays.
    EXPECT_LT(std::abs(rig.bodies.velocity(ball).x()), 1e-3);
    before = joint.position[0];
  }
  EXPECT_NEAR(before, 0.3, 1e-3);
}

// The most that a double pendulum of hinges, thrown hard, gets off its axes.
TEST(GroupJoints, LockedAxesStayParallel) {
  JointRig rig;
  rig.gravity = {0, 0, -9.81};
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t a = rig.add_dynamic({0, 0.5, 0}, 1, {0.09, 0.01, 0.09});
  const std::uint32_t b = rig.add_dynamic({0, 1.5, 0}, 1, {0.09, 0.01, 0.09});
  add_hinge_rows(rig.join_point(ground, a, {0, 0, 0}), {});
  add_hinge_rows(rig.join_point(a, b, {0, 1, 0}), {});
  rig.bodies.velocity(b) = Vector3(0.5, 0, 3);
  for (int i = 0; i < 240; ++i) {
    rig.step(dt);
    for (const Joint& joint : rig.joints) {
      const JointFrames frames = rig.frames(joint);
      EXPECT_LT(frames.axes_first.col(0).cross(frames.axes_second.col(0)).norm(), 5e-3);
      EXPECT_LT(frames.offset.norm(), 1e-2);
    }
  }
}

TEST(GroupJoints, ForceAndTorqueAreWhatHoldsTheBody) {
  JointRig rig;
  rig.gravity = {0, 0, -10};
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t beam = rig.add_dynamic({1, 0, 0}, 3, {0.1, 0.5, 0.5});
  Joint& joint = rig.join_point(ground, beam, {0, 0, 0});
  for (const Coordinate turn : {Coordinate::TurnX, Coordinate::TurnY, Coordinate::TurnZ}) {
    add_row(joint, turn, locked_law);
  }
  rig.step(dt, 240);
  EXPECT_LT((joint.force - Vector3(0, 0, 30)).norm(), 0.05);
  // The weight turns it about y by 30 N at 1 m.
  EXPECT_LT((joint.torque - Vector3(0, -30, 0)).norm(), 0.1);
  EXPECT_LT(rig.bodies.velocity(beam).norm(), 1e-3);
}

TEST(GroupJoints, GearKeepsItsPhase) {
  JointRig rig;
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t a = rig.add_ball({0, 0, 0});
  const std::uint32_t b = rig.add_ball({0, 1, 0}, 3);
  add_hinge_rows(rig.join_point(ground, a, {0, 0, 0}), {.motor_speed = 5, .motor_force = 2});
  add_hinge_rows(rig.join_point(ground, b, {0, 1, 0}), {});
  rig.join(a, b, {0, 0.5, 0}).ratio = 2;
  add_row(rig.joints[2], Coordinate::Gear, locked_law);
  rig.step(dt, 600);
  EXPECT_GT(rig.joints[0].position[2], 20);
  EXPECT_NEAR(rig.joints[0].position[2] + 2 * rig.joints[1].position[2], 0, 0.02);
}

TEST(GroupJoints, KinematicBodyTakesOthersAlong) {
  JointRig rig;
  const std::uint32_t arm = rig.add_kinematic({0, 0, 0}, {0.5, 0, 0}, {0, 0, 1});
  const std::uint32_t ball = rig.add_ball({1, 0, 0});
  Joint& joint = rig.join_point(arm, ball, {1, 0, 0});
  for (const Coordinate turn : {Coordinate::TurnX, Coordinate::TurnY, Coordinate::TurnZ}) {
    add_row(joint, turn, locked_law);
  }
  rig.step(dt, 120);
  EXPECT_LT((rig.bodies.position(ball) - Vector3(1 + std::cos(2.0), std::sin(2.0), 0)).norm(), 5e-3);
  EXPECT_NEAR(rig.bodies.angular_velocity(ball).z(), 1, 1e-3);
}

// Falling together is falling, of second order as for bodies on their own, and what turns meanwhile stays joined.
TEST(GroupJoints, JoinedBodiesFallAsOne) {
  JointRig rig;
  rig.gravity = {0, 0, -9.81};
  const std::uint32_t a = rig.add_ball({0, 0, 0});
  const std::uint32_t b = rig.add_ball({1, 0, 0}, 5);
  const Joint& joint = rig.join_point(a, b, {0.5, 0, 0});
  rig.bodies.velocity(a) = Vector3(0, 5, 0);
  rig.bodies.velocity(b) = Vector3(0, -1, 0);
  rig.step(dt, 60);
  const Vector3 centre = (rig.bodies.position(a) + 5 * rig.bodies.position(b)) / 6;
  EXPECT_LT((centre - Vector3(5.0 / 6, 0, -9.81 / 2)).norm(), 1e-5);
  EXPECT_LT(rig.frames(joint).offset.norm(), 1e-2);
}

// Let go from the side a pendulum loses a little in ten seconds, and never gains.
TEST(GroupJoints, PendulumKeepsItsEnergy) {
  JointRig rig;
  rig.gravity = {0, 0, -9.81};
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  const std::uint32_t rod = rig.add_dynamic({0.5, 0, 0}, 1, {0.02, 0.09, 0.09});
  const Joint& joint = rig.join_point(ground, rod, {0, 0, 0});
  const double height = 9.81 * 0.5;
  for (int i = 0; i < 600; ++i) {
    rig.step(dt);
    const double energy = 9.81 * rig.bodies.position(rod).z() + 0.5 * rig.bodies.velocity(rod).squaredNorm() +
                          0.5 * 0.09 * rig.bodies.angular_velocity(rod).squaredNorm();
    EXPECT_LT(energy, 0.01 * height);
    EXPECT_GT(energy, -0.02 * height);
    EXPECT_LT(rig.frames(joint).offset.norm(), 1e-3);
  }
}

class GroupJointsStabilisation : public testing::TestWithParam<solver::Stabilisation> {};

TEST_P(GroupJointsStabilisation, PendulumHolds) {
  for (const bool warm : {true, false}) {
    JointRig rig;
    rig.settings.stabilisation = GetParam();
    rig.settings.warm_starting = warm;
    rig.gravity = {0, 0, -9.81};
    const std::uint32_t ground = rig.add_fixed({0, 0, 0});
    const std::uint32_t a = rig.add_ball({0.5, 0, 0});
    const std::uint32_t b = rig.add_ball({1.5, 0, 0});
    add_hinge_rows(rig.join_point(ground, a, {0, 0, 0}, Quaternion(std::sqrt(0.5), 0, 0, std::sqrt(0.5))), {});
    rig.join_point(a, b, {1, 0, 0});
    for (int i = 0; i < 120; ++i) {
      rig.step(dt);
      for (const Joint& joint : rig.joints) EXPECT_LT(rig.frames(joint).offset.norm(), warm ? 0.02 : 0.04);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Each, GroupJointsStabilisation,
                         testing::Values(solver::Stabilisation::Soft, solver::Stabilisation::Baumgarte,
                                         solver::Stabilisation::SplitImpulse),
                         [](const auto& of) {
                           return std::string(of.param == solver::Stabilisation::Soft        ? "Soft"
                                              : of.param == solver::Stabilisation::Baumgarte ? "Baumgarte"
                                                                                             : "SplitImpulse");
                         });

TEST(GroupJoints, ToleranceStopsSweepsOnceJointsHold) {
  JointRig rig;
  rig.gravity = {0, 0, -9.81};
  rig.settings.iterations = rig.settings.relax_iterations = 200;
  rig.settings.tolerance = 1e-5;
  const std::uint32_t ground = rig.add_fixed({0, 0, 0});
  std::uint32_t last = ground;
  for (int i = 0; i < 5; ++i) {
    const std::uint32_t ball = rig.add_ball({i + 0.5, 0, 0});
    rig.join_point(last, ball, {1.0 * i, 0, 0});
    last = ball;
  }
  const GroupReport report = rig.step(dt, 10);
  EXPECT_LT(report.sweeps, 4 * 2 * 200);
  EXPECT_GT(report.sweeps, 4 * 2);
  EXPECT_EQ(report.joints, 5u);
  for (const Joint& joint : rig.joints) EXPECT_LT(rig.point_speed(joint).norm(), 1e-3);
}

}  // namespace
}  // namespace atl::test
