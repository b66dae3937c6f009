// Forces of joints, against statics, with both solvers. Those of motors and friction are in accuracy/.

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test {
namespace {

const Quaternion from_x_to_z(Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3::UnitY()));

class JointForce : public testing::TestWithParam<JointSolver> {
 protected:
  World world{WorldDef{.settings = {.joint_solver = GetParam()}}};
  BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});
};

// Every kind that can carry a crate that hangs below the post.
TEST_P(JointForce, AHangingWeightPullsWithItsWeight) {
  const JointAxis hold{.range = {0, 0}};
  const JointKind kinds[] = {BallJoint{},
                             HingeJoint{},
                             SliderJoint{},
                             FixedJoint{},
                             DistanceJoint{{.range = {1, 1}}},
                             UniversalJoint{},
                             ConeTwistJoint{},
                             SixDofJoint{{hold, hold, hold}, {}},
                             SixDofJoint{{JointAxis{}, JointAxis{}, hold}, {}},
                             WheelJoint{.suspension = hold}};
  std::vector<JointId> joints;
  std::vector<BodyId> crates;
  double x = 0;
  for (const JointKind& kind : kinds) {
    x += 5;
    const bool rod = std::holds_alternative<DistanceJoint>(kind);
    crates.push_back(world.add_body(box({x, 0, -3})));
    // The post is the second body of every other one: forces are on the second.
    JointDef def{.kind = kind, .first = post, .second = crates.back()};
    def.frame_first.position = {x, 0, -2};
    def.frame_second.position = {0, 0, rod ? 0.0 : 1.0};
    if (crates.size() % 2 == 0) {
      std::swap(def.first, def.second);
      std::swap(def.frame_first, def.frame_second);
    }
    joints.push_back(world.add_joint(def));
  }
  run(world, 120);
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double weight = world.mass(crates[i]) * g;
    const JointState state = world.joint_state(joints[i]);
    const Vector3 expected(0, 0, i % 2 == 0 ? weight : -weight);
    EXPECT_LT((state.force - expected).norm(), 1e-3 * weight) << i << ": " << state.force.transpose();
    EXPECT_LT(state.torque.norm(), 1e-3 * weight) << i << ": " << state.torque.transpose();
  }
}

// A tray that hangs on a joint, with a crate on it or none, in a world of its own.
struct Tray {
  World world;
  JointId joint;
  double weight;

  Tray(JointSolver solver, int substeps, const JointKind& kind, bool laden, double break_force = unlimited)
      : world({.settings = {.substeps = substeps, .joint_solver = solver}}) {
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}, .position = {0, 0, 3}});
    const BodyId tray = world.add_body(box({0, 0, 0}, {0.5, 0.5, 0.1}));
    joint = world.add_joint({.kind = kind,
                             .first = post,
                             .second = tray,
                             .frame_first = {{0, 0, -2}, from_x_to_z},
                             .frame_second = {{0, 0, 1}, from_x_to_z},
                             .break_force = break_force});
    weight = world.mass(tray) * g;
    if (laden) weight += world.mass(world.add_body(box({0, 0, 0.3}, {0.2, 0.2, 0.2}))) * g;
  }
};

// Joints hold alone, at an end of a range, or beside a spring.
TEST_P(JointForce, AWeightIsToldWholeWithAnyNumberOfSubsteps) {
  const JointAxis sprung{.spring = JointSpring{}};
  const JointKind kinds[] = {FixedJoint{}, SliderJoint{{.range = {0, 1}}}, HingeJoint{}, HingeJoint{sprung}};
  for (const int substeps : {1, 2, 4}) {
    for (const JointKind& kind : kinds) {
      for (const bool laden : {false, true}) {
        Tray tray(GetParam(), substeps, kind, laden);
        run(tray.world, 120);
        const Vector3 force = tray.world.joint_state(tray.joint).force;
        EXPECT_LT((force - Vector3(0, 0, tray.weight)).norm(), 0.01 * tray.weight)
            << substeps << " substeps, " << (laden ? "laden, " : "empty, ") << kind.index() << ": " << force.transpose()
            << " of " << tray.weight;
      }
    }
  }
}

TEST_P(JointForce, AJointBreaksUnderMoreThanItsLimitWithAnyNumberOfSubsteps) {
  for (const int substeps : {1, 2, 4}) {
    const double weight = Tray(GetParam(), substeps, FixedJoint{}, false).weight;
    for (const double part : {0.8, 1.2}) {
      Tray tray(GetParam(), substeps, FixedJoint{}, false, part * weight);
      run(tray.world, 60);
      EXPECT_EQ(tray.world.joint_state(tray.joint).broken, part < 1) << substeps << " substeps, " << part;
    }
  }
}

// A beam that sticks out: about the joint's place on it the torque is that of its weight.
TEST_P(JointForce, ABeamTurnsWithItsLever) {
  const BodyId beam = world.add_body(box({2, 0.5, 0}));
  const JointId joint = world.add_joint(
      {.kind = FixedJoint{}, .first = post, .second = beam, .frame_second = {{-2, -0.5, 0}, Quaternion::Identity()}});
  run(world, 240);
  const double weight = world.mass(beam) * g;
  const JointState state = world.joint_state(joint);
  const Vector3 lever = world.pose(beam).position;
  const Vector3 expected = lever.cross(Vector3(0, 0, weight));
  EXPECT_LT((state.force - Vector3(0, 0, weight)).norm(), 1e-3 * weight) << state.force.transpose();
  EXPECT_LT((state.torque - expected).norm(), 2e-3 * expected.norm())
      << state.torque.transpose() << " instead of " << expected.transpose();
}

// A rotor on an upright axle.
struct Rotor {
  BodyId body;
  JointId hinge;

  Rotor(World& world, BodyId post, const JointAxis& angle) : body(world.add_body(box({0, 0, 2}))) {
    hinge = world.add_joint({.kind = HingeJoint{angle},
                             .first = post,
                             .second = body,
                             .frame_first = {{0, 0, 2}, from_x_to_z},
                             .frame_second = {{0, 0, 0}, from_x_to_z}});
  }
};

// Driven on one side, a gear turns the other one back, by its ratio and over many turns.
TEST_P(JointForce, AGearKeepsItsPhase) {
  const Rotor driver(world, post, {.motor = JointMotor{5, unlimited}});
  const BodyId wheel = world.add_body(box({3, 0, 2}));
  const JointId axle = world.add_joint({.kind = HingeJoint{{.range = {-1e3, 1e3}}},
                                        .first = post,
                                        .second = wheel,
                                        .frame_first = {{3, 0, 2}, from_x_to_z},
                                        .frame_second = {{0, 0, 0}, from_x_to_z}});
  world.add_joint({.kind = GearJoint{.ratio = 2},
                   .first = driver.body,
                   .second = wheel,
                   .frame_first = {{0, 0, 0}, from_x_to_z},
                   .frame_second = {{0, 0, 0}, from_x_to_z}});
  run(world, 300);
  const double turned = world.joint_state(driver.hinge).position[0];
  EXPECT_GT(turned, 20);
  EXPECT_NEAR(turned + 2 * world.joint_state(axle).position[0], 0, 0.02);
}

std::string solver_name(const testing::TestParamInfo<JointSolver>& info) {
  return info.param == JointSolver::Iterative ? "Iterative" : "Direct";
}
INSTANTIATE_TEST_SUITE_P(Solvers, JointForce, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         solver_name);

}  // namespace
}  // namespace atl::test
