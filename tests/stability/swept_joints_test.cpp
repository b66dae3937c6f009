// Joints that are swept: what one joint locks is solved by one sweep, and what hangs together doesn't break.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <variant>

#include "support/bodies.h"
#include "support/motion.h"
#include "support/random.h"
#include "support/random_assembly.h"

namespace atl::test::swept_joints_test {
namespace {

// A brick at the end of a long arm, which tumbles as its joint is made: one sweep that pushes and one that relaxes
// leave no more than rounding of the motions that the joint locks.
TEST(SweptJoints, ASweepSolvesAllThatAJointLocks) {
  for (const JointKind& kind : {JointKind(FixedJoint{}), JointKind(HingeJoint{}), JointKind(UniversalJoint{})}) {
    World world({.gravity = Vector3::Zero(),
                 .settings = {.substeps = 1, .iterations = 1, .joint_solver = JointSolver::Iterative}});
    const BodyId base = world.add_body(static_box({0, 0, 0}, Vector3::Constant(0.05)));
    BodyDef brick = box({1.2, 0.3, -0.4}, {0.1, 0.06, 0.03});
    brick.velocity = {0.3, -0.2, 0.5};
    brick.angular_velocity = {0.4, 0.7, -0.6};
    const BodyId id = world.add_body(brick);
    world.add_joint(joint_at(world, kind, base, id, {0.1, 0, 0}, Vector3::UnitZ()));
    world.step(1e-4);
    const Vector3 spin = world.angular_velocity(id);
    const Vector3 at_joint = world.velocity(id) + spin.cross(Vector3(0.1, 0, 0) - world.pose(id).position);
    EXPECT_LT(at_joint.norm(), 5e-5) << kind.index();
    if (std::holds_alternative<FixedJoint>(kind)) {
      EXPECT_LT(spin.norm(), 2e-6);
    }
    if (std::holds_alternative<HingeJoint>(kind)) {
      EXPECT_LT(spin.head<2>().norm(), 2e-6);
    }
  }
}

// A body that only turns can't close a gap along its arm, and doesn't turn for it, wherever the arm points.
TEST(SweptJoints, AGapThatNothingClosesMovesNothing) {
  Random random(3);
  for (int run = 0; run < 200; ++run) {
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = JointSolver::Iterative}});
    const Vector3 arm = random.real(0.2, 2) * random.direction();
    const BodyId base = world.add_body(static_box({5, 0, 0}, Vector3::Constant(0.1)));
    BodyDef def = box({0, 0, 0}, {0.2, 0.1, 0.05});
    def.orientation = random.rotation();
    def.locks.linear = {true, true, true};
    const BodyId id = world.add_body(def);
    const Vector3 anchor = world.pose(id).orientation.conjugate() * (0.95 * arm);
    world.add_joint({.kind = BallJoint{},
                     .first = base,
                     .second = id,
                     .frame_first = {.position = arm - Vector3(5, 0, 0)},
                     .frame_second = {.position = anchor}});
    for (int i = 0; i < 60; ++i) world.step(dt);
    EXPECT_LT(world.angular_velocity(id).norm(), 1e-4) << arm.transpose();
  }
}

// Loops that hold things twice, gears and ranges among them, at the defaults. One breaks, whose masses are as 390 to 1.
TEST(SweptJoints, AssembliesStayWhole) {
  int broken = 0;
  for (std::uint64_t seed = 0; seed < 150; ++seed) {
    Assembly made = random_assembly(seed, {.motors = false, .springs = false, .apart = false});
    made.world.settings = {.joint_solver = JointSolver::Iterative};
    World world(made.world);
    add_to(world, made);
    run(world, 300);
    broken += world.quarantined().empty() ? 0 : 1;
  }
  EXPECT_LE(broken, 1);
}

// An end of a range that is exceeded has a spring and a motor behind it, by all ways to close joints.
TEST(SweptJoints, ASprungMotorComesBackIntoItsRange) {
  for (const Stabilisation how : {Stabilisation::Soft, Stabilisation::Baumgarte, Stabilisation::SplitImpulse}) {
    World world(
        {.gravity = Vector3::Zero(), .settings = {.stabilisation = how, .joint_solver = JointSolver::Iterative}});
    const BodyId base = world.add_body(static_box({0, 0, 0}, Vector3::Constant(0.1)));
    const BodyId arm = world.add_body(box({0.5, 0, 0}, {0.3, 0.05, 0.05}));
    const HingeJoint hinge = {.angle = {.range = {0.2, 0.5},
                                        .spring = JointSpring{2, 0.7},
                                        .motor = JointMotor{.speed = -1, .max_force = 0.5}}};
    const JointId id = world.add_joint(joint_at(world, hinge, base, arm, {0, 0, 0}, Vector3::UnitZ()));
    for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
    EXPECT_NEAR(world.joint_state(id).position[0], 0.2, 0.01) << static_cast<int>(how);
    EXPECT_LT(world.angular_velocity(arm).norm(), 1e-3) << static_cast<int>(how);
  }
}

// Springs on angles that change without end where two axes are along each other: a slab that tumbles through there for
// a minute has no more energy than it began with.
TEST(SweptJoints, SpringsGainNoEnergyWhereTheirAnglesFade) {
  constexpr double stiffness = 2, rest = 0.3;
  constexpr JointAxis locked = {.range = {0, 0}};
  const JointAxis sprung = {.spring = JointSpring{.rest = rest, .stiffness = stiffness}};
  const SixDofJoint gimbal = {
      .offset = {locked, locked, locked}, .turn = {sprung, JointAxis{}, sprung}, .turns = SixDofTurns::AnglesXYZ};
  for (const JointKind& kind : {JointKind(gimbal), JointKind(ConeTwistJoint{.twist = sprung})}) {
    for (std::uint32_t seed = 0; seed < 20; ++seed) {
      Random random(seed);
      World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = JointSolver::Iterative}});
      const BodyId base = world.add_body({.type = BodyType::Static, .filter = {.mask = 0}});
      const BodyId slab = world.add_body({.shape = Box{{0.3, 0.2, 0.25}}, .mass = 20, .filter = {.mask = 0}});
      world.set_velocity(slab, Vector3::Zero(), random.vector(3));
      world.add_joint({.kind = kind, .first = base, .second = slab});
      const double all = motion_of(world).kinetic + stiffness * rest * rest;
      double max = 0;
      for (int i = 0; i < 3600; ++i) {
        world.step(1.0 / 60);
        max = std::max(max, motion_of(world).kinetic);
      }
      EXPECT_LT(max, 1.02 * all) << kind.index() << ", seed " << seed;
    }
  }
}

// Two wheels on springs of a frequency, at a beam.
struct Axle {
  World world;
  BodyId beam;

  explicit Axle(double hertz) : world({.settings = {.substeps = 4}}) {
    world.add_body(ground());
    beam = world.add_body(box({0, 0, 0.9}, {1, 0.4, 0.3}));
    for (const double side : {-0.8, 0.8}) {
      const Vector3 at(side, 0, 0.35);
      const BodyId wheel = world.add_body(sphere(at, 0.3));
      const WheelJoint joint = {.suspension = {.range = {-0.3, 0.3}, .spring = JointSpring{hertz, 0.7}}};
      world.add_joint(joint_at(world, joint, beam, wheel, at));
    }
  }
};

// A spring's stiffness relative to the substep decides who solves it, also as the step length changes and after a
// restore.
TEST(SweptJoints, SpringsThatSubstepsCantFollowAreSolvedAtOnce) {
  EXPECT_EQ(Axle(2).world.step(1.0 / 60).counts.direct_joints, 0);
  EXPECT_EQ(Axle(60).world.step(1.0 / 60).counts.direct_joints, 2);
  Axle axle(60);
  std::vector<std::uint64_t> trail;
  Snapshot half;
  for (int i = 0; i < 20; ++i) {
    if (i == 10) axle.world.save(half);
    const bool fine = i % 8 > 3;
    EXPECT_EQ(axle.world.step(fine ? 1.0 / 960 : 1.0 / 60).counts.direct_joints, fine ? 0 : 2) << i;
    trail.push_back(axle.world.state_hash());
  }
  Axle other(2);
  other.world.restore(half);
  for (std::size_t i = 10; i < 20; ++i) {
    other.world.step(i % 8 > 3 ? 1.0 / 960 : 1.0 / 60);
    ASSERT_EQ(other.world.state_hash(), trail[i]) << i;
  }
}

}  // namespace
}  // namespace atl::test::swept_joints_test
