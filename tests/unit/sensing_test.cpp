// Readings of instruments on bodies and joints: accelerometers, force plates, and the torque of motors.

#include <atoll/batch.h>
#include <atoll/forces.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"

namespace atl::test::sensing_test {
namespace {

constexpr double mass = 2;

World world_of(const Vector3& gravity, Settings settings = {}) {
  settings.accelerations = true;
  return World({.gravity = gravity, .settings = settings});
}

TEST(Sensing, AnAccelerometerReadsWhatHoldsItUp) {
  World world = world_of({0, 0, -g});
  world.add_body(ground());
  const Quaternion on_its_side(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX()));
  const BodyId crate =
      world.add_body({.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, 0.5}, .orientation = on_its_side});
  const BodyId falling = world.add_body({.shape = Sphere{0.1}, .position = {9, 0, 50}});
  const BodyId floating = world.add_body({.shape = Sphere{0.1}, .position = {12, 0, 50}, .gravity_scale = 0.5});
  run(world, 60);
  EXPECT_LT((world.proper_acceleration(crate, {0.3, 0.2, 0.1}) - Vector3(0, g, 0)).norm(), 1e-3);
  EXPECT_LT(world.proper_acceleration(falling).norm(), 1e-6);
  EXPECT_LT(world.proper_acceleration(floating).norm(), 1e-6);
  EXPECT_NEAR(world.accelerations()(2, falling.index), -g, 1e-6);
}

TEST(Sensing, AnAccelerometerOffTheAxisReadsWhatKeepsItOnItsCircle) {
  World world = world_of(Vector3::Zero());
  const double spin = 3, arm = 0.5, push = 8;
  const BodyId ball = world.add_body({.shape = Sphere{1}, .angular_velocity = {0, 0, spin}, .mass = mass});
  world.step(dt);
  EXPECT_LT((world.proper_acceleration(ball, {arm, 0, 0}) - Vector3(-spin * spin * arm, 0, 0)).norm(), 1e-5);
  // A force and a torque for a step, and for one under a law that gives as much.
  const double moment = 0.4 * mass;
  for (const bool by_law : {false, true}) {
    const Vector3 torque(0, 0, push);
    if (by_law) {
      world.step(dt, [&](Forces& forces) { forces.add(ball, {push, 0, 0}, torque); });
    } else {
      world.apply_force(ball, {push, 0, 0}, torque);
      world.step(dt);
    }
    EXPECT_NEAR(world.accelerations()(0, ball.index), push / mass, 1e-5);
    EXPECT_NEAR(world.angular_accelerations()(2, ball.index), push / moment, 1e-5);
    const Vector3 axis = world.pose(ball).orientation * Vector3(arm, 0, 0);
    const double rate = world.angular_velocity(ball).z();
    const Vector3 expected = Vector3(push / mass, 0, 0) + Vector3(0, 0, push / moment).cross(axis) - rate * rate * axis;
    EXPECT_LT((world.pose(ball).orientation * world.proper_acceleration(ball, {arm, 0, 0}) - expected).norm(), 1e-4);
  }
  // Calls between steps, and new bodies, are no acceleration.
  world.set_velocity(ball, {9, 9, 9}, Vector3::Zero());
  const BodyId late = world.add_body({});
  EXPECT_EQ(world.accelerations().col(late.index).norm(), 0);
  EXPECT_NEAR(world.accelerations()(0, ball.index), push / mass, 1e-5);
}

TEST(Sensing, WithoutAStepThereIsNothingToRead) {
  World world;
  const BodyId body = world.add_body({});
  world.step(dt);
  expect_error([&] { world.accelerations(); }, {"Settings::accelerations"});
  world = world_of({0, 0, -g});
  const BodyId other = world.add_body({});
  expect_error([&] { world.proper_acceleration(other); }, {"Settings::accelerations"});
  world.step(dt);
  EXPECT_NO_THROW(world.proper_acceleration(other));
  expect_error([&] { world.proper_acceleration(other, {NAN, 0, 0}); }, {"point", "finite"});
  Snapshot snapshot;
  world.save(snapshot);
  world.restore(snapshot);
  expect_error([&] { world.angular_accelerations(); }, {"restored"});
  EXPECT_EQ(body.index, 0u);
}

class ContactWrench : public testing::TestWithParam<ContactSolver> {
 protected:
  World world{{.settings = {.contact_solver = GetParam()}}};
  BodyId floor = world.add_body(ground());

  void expect(BodyId body, const Vector3& force, const Vector3& torque, double tolerance) {
    const Wrench found = world.contact_wrench(body), on_floor = world.contact_wrench(floor);
    EXPECT_LT((found.force - force).norm(), tolerance) << found.force.transpose();
    EXPECT_LT((found.torque - torque).norm(), tolerance) << found.torque.transpose();
    EXPECT_EQ(on_floor.force, -found.force);
    const Eigen::Matrix<double, 6, Eigen::Dynamic> all = world.contact_wrenches();
    EXPECT_EQ(all.col(body.index), (Eigen::Matrix<double, 6, 1>() << found.force, found.torque).finished());
  }
};

// Nothing turns, so that its torque about the centre of mass is nil however the points share the load.
TEST_P(ContactWrench, OfACrateThatIsPulledAtRestBalancesThePull) {
  const BodyId crate = world.add_body({.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, 0.5}, .mass = mass});
  const double pull = 0.3 * mass * g;
  for (int step = 0; step < 60; ++step) {
    world.apply_force(crate, {pull, 0, 0});
    world.step(dt);
  }
  expect(crate, {-pull, 0, mass * g}, Vector3::Zero(), 1e-2);
}

TEST_P(ContactWrench, OfABallThatSpinsIsWhatSlowsItDown) {
  const double lever = 0.02;
  const BodyId ball = world.add_body({.shape = Sphere{0.5},
                                      .position = {0, 0, 0.5},
                                      .angular_velocity = {0, 0, 20},
                                      .mass = mass,
                                      .material = {.torsional_friction = lever}});
  run(world, 30);
  const double before = world.angular_velocity(ball).z(), moment = 0.4 * mass * 0.25;
  run(world, 1);
  const double torque = moment * (world.angular_velocity(ball).z() - before) / dt;
  EXPECT_NEAR(torque, -lever * mass * g, 1e-3);
  expect(ball, {0, 0, mass * g}, {0, 0, torque}, 1e-2);
}

TEST_P(ContactWrench, OfABallThatRollsHasTheTorqueAgainstRolling) {
  const double lever = 0.02, radius = 0.5;
  const BodyId ball = world.add_body({.shape = Sphere{radius},
                                      .position = {0, 0, radius},
                                      .velocity = {4, 0, 0},
                                      .angular_velocity = {0, 4 / radius, 0},
                                      .mass = mass,
                                      .material = {.rolling_friction = lever}});
  run(world, 30);
  // m a = -F and 2/5 m r^2 (a / r) = F r - lever m g.
  const double friction = lever * mass * g / (1.4 * radius);
  expect(ball, {-friction, 0, mass * g}, {0, friction * radius - lever * mass * g, 0}, 2e-2);
}

INSTANTIATE_TEST_SUITE_P(Solvers, ContactWrench, testing::Values(ContactSolver::Iterative, ContactSolver::Direct),
                         [](const auto& of) { return of.param == ContactSolver::Direct ? "Direct" : "Iterative"; });

struct HowSolved {
  const char* name;
  Settings settings;
};
void PrintTo(const HowSolved& how, std::ostream* out) { *out << how.name; }

// A slider along z, or a hinge about x whose weight is at an arm of 1 m along y.
class MotorForce : public testing::TestWithParam<HowSolved> {
 protected:
  World world{{.settings = GetParam().settings}};
  BodyId post = world.add_body({.type = BodyType::Static, .shape = Box{}});

  JointState slide(const JointAxis& axis, int steps = 240) {
    const Quaternion up(Eigen::AngleAxisd(-std::numbers::pi / 2, Vector3::UnitY()));
    const BodyId load = world.add_body({.shape = Sphere{0.1}, .position = {3, 0, 0}, .mass = mass});
    const JointId joint = world.add_joint({.kind = SliderJoint{axis},
                                           .first = post,
                                           .second = load,
                                           .frame_first = {{3, 0, 0}, up},
                                           .frame_second = {{}, up}});
    run(world, steps);
    return world.joint_state(joint);
  }
};

TEST_P(MotorForce, LiftsAWeight) {
  const JointState state = slide({.motor = JointMotor{.speed = 0.2, .max_force = 100}});
  EXPECT_NEAR(state.speed[0], 0.2, 1e-4);
  EXPECT_NEAR(state.motor[0], mass * g, 1e-2);
  EXPECT_NEAR(state.force.z(), mass * g, 1e-2);
}

TEST_P(MotorForce, IsApartFromThatOfSpringsAndFriction) {
  const double rubs = 5, stiffness = 30, from = 0;
  const JointState state = slide({.spring = JointSpring{.rest = from, .stiffness = stiffness},
                                  .motor = JointMotor{.speed = 0.2, .max_force = 100},
                                  .friction = rubs});
  const double spring = stiffness * state.position[0];
  ASSERT_GT(spring, 10);
  EXPECT_NEAR(state.motor[0], mass * g + rubs + spring, 0.1);
  EXPECT_NEAR(state.force.z(), mass * g, 1e-2);
}

TEST_P(MotorForce, IsApartFromThatOfASpringByItsFrequency) {
  const double omega = 2 * std::numbers::pi * 0.5;
  const JointState state = slide(
      {.spring = JointSpring{.hertz = 0.5, .damping_ratio = 0.5}, .motor = JointMotor{.speed = 0.2, .max_force = 100}});
  const double spring = mass * omega * (omega * state.position[0] + 2 * 0.5 * 0.2);
  ASSERT_GT(spring, 5);
  EXPECT_NEAR(state.motor[0], mass * g + spring, 0.1);
}

TEST_P(MotorForce, IsAllItHasAtTheEndOfItsRange) {
  const double max = 60;
  const JointState state = slide({.range = {-1, 0.1}, .motor = JointMotor{.speed = 0.5, .max_force = max}});
  EXPECT_NEAR(state.position[0], 0.1, 1e-2);
  EXPECT_NEAR(state.motor[0], max, 1e-9);
  EXPECT_NEAR(state.force.z(), mass * g, 1e-1);
}

TEST_P(MotorForce, OfAServoHoldsTheWeightAtItsOffset) {
  const JointState state = slide(
      {.motor = JointMotor{.max_force = 100, .servo = JointServo{.target = 0.1, .stiffness = 500, .damping = 60}}});
  EXPECT_NEAR(state.position[0], 0.1 - mass * g / 500, 1e-3);
  EXPECT_NEAR(state.motor[0], mass * g, 0.1);
}

TEST_P(MotorForce, IsNilWithoutAMotor) {
  const JointState state = slide({.range = {0, 0}});
  EXPECT_EQ(state.motor[0], 0);
  EXPECT_NEAR(state.force.z(), mass * g, 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Solvers, MotorForce,
                         testing::Values(HowSolved{"Iterative", {.joint_solver = JointSolver::Iterative}},
                                         HowSolved{"Direct", {.joint_solver = JointSolver::Direct}},
                                         HowSolved{"ToATarget",
                                                   {.target = {.motion = 1e-3, .min_substeps = 3},
                                                    .joint_solver = JointSolver::Direct}}),
                         [](const auto& of) { return of.param.name; });

TEST(Sensing, ABatchReadsAsItsWorldsDo) {
  Scene scene;
  scene.settings.accelerations = true;
  scene.bodies.push_back({.def = ground()});
  scene.bodies.push_back({.def = {.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, 0.5}, .mass = mass}});
  scene.bodies.push_back({.def = {.shape = Sphere{0.2}, .position = {0, 0, 3}, .mass = 1}});
  scene.joints.push_back(
      {.def = {.kind = SliderJoint{{.motor = JointMotor{.speed = 1, .max_force = 50}, .friction = 2}}}});
  scene.joints[0].first = 0;
  scene.joints[0].second = 2;
  scene.joints[0].def.frame_first.position = {0, 0, 3};
  Batch batch(scene, 2, 1);
  batch.step(dt, 20);
  const World& world = batch.world(1);
  const auto read = [&](Batch::Column column, std::size_t place) {
    const std::size_t rows = Batch::rows_of(column);
    std::vector<double> numbers(2 * rows * (is_of_joints(column) ? 1 : 3));
    batch.read(column, numbers);
    return std::vector<double>(numbers.end() - static_cast<std::ptrdiff_t>(rows * place), numbers.end());
  };
  const auto same = [](const std::vector<double>& found, const double* expected) {
    return std::equal(found.begin(), found.end(), expected);
  };
  const std::uint32_t last = batch.bodies()[2].index, crate = batch.bodies()[1].index;
  EXPECT_TRUE(same(read(Batch::Column::Accelerations, 1), world.accelerations().col(last).data()));
  EXPECT_TRUE(same(read(Batch::Column::AngularAccelerations, 1), world.angular_accelerations().col(last).data()));
  const Wrench wrench = world.contact_wrench(batch.bodies()[1]);
  EXPECT_GT(wrench.force.z(), 0);
  EXPECT_EQ(world.contact_wrenches().col(crate).head<3>(), wrench.force);
  EXPECT_EQ(read(Batch::Column::ContactForces, 2)[2], wrench.force.z());
  EXPECT_EQ(read(Batch::Column::ContactTorques, 2)[0], wrench.torque.x());
  const JointState state = world.joint_state(batch.joints()[0]);
  EXPECT_GT(state.motor[0], 0);
  EXPECT_TRUE(same(read(Batch::Column::JointMotors, 1), state.motor.data()));
  EXPECT_TRUE(same(read(Batch::Column::JointForces, 1), state.force.data()));
  EXPECT_TRUE(same(read(Batch::Column::JointTorques, 1), state.torque.data()));
}

}  // namespace
}  // namespace atl::test::sensing_test
