// Tendons, which couple coordinates of several joints, against closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/joined_run.h"

namespace atl::test::tendon_test {
namespace {

// Cubes on a post, each on a hinge about z through its centre.
struct Rotors {
  static constexpr double mass = 6;     // kg
  static constexpr double inertia = 1;  // kg m^2, of an edge of 1 m

  explicit Rotors(int count, JointSolver solver = JointSolver::Auto, int substeps = 4)
      : world({.gravity = Vector3::Zero(), .settings = {.substeps = substeps, .joint_solver = solver}}) {
    const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    for (int i = 0; i < count; ++i) {
      BodyDef def = box({2.0 * i, 0, 0});
      def.mass = mass;
      cubes.push_back(world.add_body(def));
      hinges.push_back(
          world.add_joint(joint_at(world, HingeJoint{}, post, cubes.back(), {2.0 * i, 0, 0}, Vector3::UnitZ())));
    }
  }

  // Linear, with a factor for each of the first hinges.
  JointId add_tendon(const std::vector<double>& factors, const JointAxis& length) {
    TendonJoint tendon{.length = length};
    for (std::size_t i = 0; i < factors.size(); ++i) {
      tendon.terms.push_back({.joint = hinges[i], .polynomial = {0, factors[i]}});
    }
    return world.add_joint({.kind = tendon});
  }
  void push(std::size_t cube, double torque) { world.apply_force(cubes[cube], Vector3::Zero(), {0, 0, torque}); }
  double angle(std::size_t cube) const { return world.joint_state(hinges[cube]).position[0]; }
  double speed(std::size_t cube) const { return world.angular_velocity(cubes[cube]).z(); }

  World world;
  std::vector<BodyId> cubes;
  std::vector<JointId> hinges;
};

constexpr JointAxis locked = {.range = {0, 0}};

class TendonTest : public testing::TestWithParam<JointSolver> {
 protected:
  bool direct() const { return GetParam() == JointSolver::Direct; }
};

TEST_P(TendonTest, GearedRotorsTurnAsOneOfTheSumOfTheirInertias) {
  constexpr double ratio = 3, torque = 2;
  Rotors rotors(2, GetParam());
  rotors.add_tendon({1, -ratio}, locked);  // the first turns three times as far
  for (int step = 0; step < 60; ++step) {
    rotors.push(1, torque);
    rotors.world.step(dt);
  }
  const double speed = torque / (Rotors::inertia * (1 + ratio * ratio));
  EXPECT_NEAR(rotors.speed(1), speed, 1e-5 * speed);
  EXPECT_NEAR(rotors.speed(0), ratio * speed, 1e-5 * ratio * speed);
  EXPECT_NEAR(rotors.angle(0), ratio * rotors.angle(1), direct() ? 1e-10 : 1e-4);
}

// Three pendulums in one plane, whose angles a tendon adds up, keep their energy but not their momentum.
TEST_P(TendonTest, CoupledPendulumsKeepTheirEnergy) {
  World world({.settings = {.joint_solver = GetParam()}});
  const BodyId post = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
  std::vector<BodyId> bobs;
  TendonJoint tendon{.length = locked};
  for (int i = 0; i < 3; ++i) {
    const Vector3 top(0, 2.0 * i, 0);
    bobs.push_back(world.add_body(box(top - Vector3(0, 0, 0.5 + 0.25 * i), {0.1, 0.1, 0.25})));
    const JointId hinge = world.add_joint(joint_at(world, HingeJoint{}, post, bobs.back(), top, Vector3::UnitY()));
    tendon.terms.push_back({.joint = hinge, .polynomial = {0, 1.0 + i}});
  }
  const JointId sum = world.add_joint({.kind = tendon});
  const auto energy = [&] {
    double total = 0;
    for (const BodyId bob : bobs) {
      const double mass = world.mass(bob);
      const Vector3 moment = box_inertia(mass, {0.1, 0.1, 0.25});
      const double spin = world.angular_velocity(bob).y();
      total += 0.5 * (mass * world.velocity(bob).squaredNorm() + moment.y() * spin * spin) +
               mass * g * world.pose(bob).position.z();
    }
    return total;
  };
  // Speeds that the tendon lets them have: 2 + 2 * 2 - 3 * 2 is 0.
  const double speeds[3] = {2, 2, -2};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3 spin(0, speeds[i], 0);
    const Vector3 arm = world.pose(bobs[i]).position - Vector3(0, 2.0 * static_cast<double>(i), 0);
    world.set_velocity(bobs[i], spin.cross(arm), spin);
  }
  const double before = energy();
  double kinetic = 0;
  for (const BodyId bob : bobs) kinetic += 0.5 * world.mass(bob) * world.velocity(bob).squaredNorm();
  double drift = 0, gap = 0;
  for (int step = 0; step < 600; ++step) {
    world.step(dt);
    drift = std::max(drift, std::abs(energy() - before));
    gap = std::max(gap, std::abs(world.joint_state(sum).position[0]));
  }
  EXPECT_LT(drift, (direct() ? 0.01 : 0.1) * kinetic);
  EXPECT_LT(gap, direct() ? 1e-7 : 2e-3);
}

TEST_P(TendonTest, AMimicFollowsAPolynomial) {
  constexpr double c1 = 0.5, c2 = 0.3, c3 = -0.2, c4 = 0.1;
  Rotors rotors(2, GetParam());
  rotors.world.add_joint(
      {.kind = TendonJoint{
           .terms = {{.joint = rotors.hinges[0]}, {.joint = rotors.hinges[1], .polynomial = {0, -c1, -c2, -c3, -c4}}},
           .length = locked}});
  double farthest = 0, off = 0;
  for (int step = 0; step < 300; ++step) {
    const double q = rotors.angle(1);
    rotors.push(1, 1.5 * std::cos(0.02 * step) - 0.2 * q);
    rotors.world.step(dt);
    const double now = rotors.angle(1);
    farthest = std::max(farthest, std::abs(now));
    off = std::max(off, std::abs(rotors.angle(0) - now * (c1 + now * (c2 + now * (c3 + now * c4)))));
  }
  EXPECT_GT(farthest, 1);
  EXPECT_LT(off, direct() ? 1e-6 : 1e-3);
}

// Factors are lever arms: what pulls along the tendon turns each joint by that force times its own.
TEST_P(TendonTest, AMotorTurnsEachJointByItsFactor) {
  constexpr double force = 5;
  const std::vector<double> factors = {0.5, -2, 1};
  Rotors rotors(3, GetParam());
  const JointId tendon = rotors.add_tendon(factors, {.motor = JointMotor{.speed = 1e3, .max_force = force}});
  run(rotors.world, 30);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(rotors.speed(i), factors[i] * force * 0.5 / Rotors::inertia, 1e-5) << i;
  }
  EXPECT_NEAR(rotors.world.joint_state(tendon).force.x(), force, 1e-6);
  double rate = 0;
  for (std::size_t i = 0; i < 3; ++i) rate += factors[i] * rotors.speed(i);
  EXPECT_NEAR(rotors.world.joint_state(tendon).speed[0], rate, 1e-9);
}

TEST_P(TendonTest, AServoHoldsTheSumWhereItIsTold) {
  Rotors rotors(2, GetParam());
  const JointServo servo = {.target = 0.4, .stiffness = 100, .damping = 20};
  const JointId tendon = rotors.add_tendon({1, 1}, {.motor = JointMotor{.max_force = 50, .servo = servo}});
  run(rotors.world, 240);
  EXPECT_NEAR(rotors.world.joint_state(tendon).position[0], 0.4, 1e-4);
  rotors.world.set_servo_target(tendon, -0.2);
  run(rotors.world, 240);
  EXPECT_NEAR(rotors.angle(0), -0.1, 1e-4);
  EXPECT_NEAR(rotors.angle(1), -0.1, 1e-4);
}

// Two like rotors that swing together on the spring between the sum of their angles and 0.
TEST_P(TendonTest, ASpringHasTheFrequencyOfItsEffectiveMass) {
  constexpr double stiffness = 8, speed = 0.1;
  Rotors rotors(2, GetParam());
  const JointId tendon = rotors.add_tendon({1, 1}, {.spring = JointSpring{.stiffness = stiffness}});
  for (const BodyId cube : rotors.cubes) rotors.world.set_velocity(cube, Vector3::Zero(), {0, 0, speed});
  const double omega = std::sqrt(stiffness * 2 / Rotors::inertia);
  double off = 0;
  for (int step = 1; step <= 120; ++step) {
    rotors.world.step(dt);
    off = std::max(
        off, std::abs(rotors.world.joint_state(tendon).position[0] - 2 * speed / omega * std::sin(omega * step * dt)));
  }
  EXPECT_LT(off, (direct() ? 1e-3 : 2e-2) * 2 * speed / omega);
}

// Friction along the difference of two angles carries the second rotor along, and slips where that takes too much.
TEST_P(TendonTest, DryFrictionSticksAndSlips) {
  constexpr double friction = 1;
  for (const double torque : {1.5, 4.0}) {
    Rotors rotors(2, GetParam());
    rotors.add_tendon({1, -1}, {.friction = friction});
    for (int step = 0; step < 60; ++step) {
      rotors.push(0, torque);
      rotors.world.step(dt);
    }
    const bool slips = torque > 2 * friction;
    EXPECT_NEAR(rotors.speed(0), slips ? torque - friction : torque / 2, 1e-4);
    EXPECT_NEAR(rotors.speed(1), slips ? friction : torque / 2, 1e-4);
  }
}

TEST_P(TendonTest, ARangeStopsTheSum) {
  constexpr double torque = 0.7;
  Rotors rotors(2, GetParam());
  const JointId tendon = rotors.add_tendon({1, 1}, {.range = {-0.1, 0.3}});
  bool reached = false;
  for (int step = 0; step < 120; ++step) {
    for (std::size_t i = 0; i < 2; ++i) rotors.push(i, torque);
    rotors.world.step(dt);
    for (const JointEvent& event : rotors.world.joint_events()) {
      reached |= event.joint == tendon && event.kind == JointEventKind::ReachedLimit;
    }
  }
  EXPECT_NEAR(rotors.world.joint_state(tendon).position[0], 0.3, direct() ? 1e-6 : 1e-3);
  EXPECT_NEAR(rotors.world.joint_state(tendon).force.x(), -torque, 1e-3);
  EXPECT_TRUE(reached);
}

// Sliders towards each other, of which a motor drives one and the other mimics it, grip a box by friction.
TEST_P(TendonTest, AMimickingGripperHoldsABox) {
  World world({.settings = {.joint_solver = GetParam()}});
  const BodyId palm = world.add_body(static_box({0, 0, 1.2}, {0.1, 0.1, 0.02}));
  const Material rubber = {.friction = 0.8};
  std::vector<JointId> sliders;
  for (const double side : {-1.0, 1.0}) {
    BodyDef finger = box({0.15 * side, 0, 0.8}, {0.02, 0.05, 0.1});
    finger.mass = 0.2;
    finger.material = rubber;
    const BodyId body = world.add_body(finger);
    sliders.push_back(
        world.add_joint(joint_at(world, SliderJoint{}, palm, body, {0.15 * side, 0, 0.8}, {-side, 0, 0})));
  }
  world.set_joint_axis(sliders[0], {.motor = JointMotor{.speed = 0.2, .max_force = 20}});
  const JointId mimic = world.add_joint(
      {.kind = TendonJoint{.terms = {{.joint = sliders[0]}, {.joint = sliders[1], .polynomial = {0, -1}}},
                           .length = locked}});
  BodyDef load = box({0.01, 0, 0.75}, Vector3::Constant(0.04));
  load.mass = 0.3;
  load.material = rubber;
  const BodyId block = world.add_body(load);
  const BodyId table = world.add_body(static_box({0, 0, 0.68}, {0.03, 0.06, 0.03}));
  run(world, 60);
  world.remove_body(table);
  run(world, 60);
  const double held = world.pose(block).position.z();
  run(world, 180);
  EXPECT_NEAR(world.pose(block).position.z(), held, 2e-3);
  EXPECT_NEAR(held, 0.75, 2e-3);
  EXPECT_NEAR(world.pose(block).position.x(), 0, 2e-3) << "both come as far";
  EXPECT_NEAR(world.joint_state(mimic).position[0], 0, direct() ? 1e-5 : 5e-3);
}

// A rope over two pulleys, the second a tackle of two parts: the length of the one rope and twice the other's is that
// of the whole. The weights move as F = m a says of both, and a weight that is lifted lets it go slack.
TEST_P(TendonTest, ARopeOverPulleysMovesTwoWeights) {
  constexpr double light = 1, heavy = 3;  // kg
  World world({.settings = {.joint_solver = GetParam()}});
  const BodyId ceiling = world.add_body(static_box({0, 0, 3.5}, {3, 0.5, 0.5}));
  std::vector<BodyId> weights;
  std::vector<TendonTerm> terms;
  for (const double side : {-1.0, 1.0}) {
    BodyDef weight = sphere({side, 0, 0}, 0.1);
    weight.mass = side < 0 ? light : heavy;
    weights.push_back(world.add_body(weight));
    const JointId rope = world.add_joint({.kind = DistanceJoint{{.range = {0, unlimited}}},
                                          .first = ceiling,
                                          .second = weights.back(),
                                          .frame_first = {{side, 0, -0.5}, Quaternion::Identity()}});
    terms.push_back({.joint = rope, .polynomial = {0, side < 0 ? 1.0 : 2.0}});
  }
  const JointId rope = world.add_joint({.kind = TendonJoint{.terms = terms, .length = {.range = {-unlimited, 9}}}});
  run(world, 30);
  const double falls = g * (heavy - 2 * light) / (heavy + 4 * light);  // m/s^2, the heavy one
  EXPECT_NEAR(world.velocity(weights[1]).z(), -falls * 0.5, 1e-3);
  EXPECT_NEAR(world.velocity(weights[0]).z(), 2 * falls * 0.5, 2e-3);
  EXPECT_NEAR(world.joint_state(rope).force.x(), -light * (g + 2 * falls), 0.02) << "N, along the rope";
  EXPECT_NEAR(world.joint_state(rope).position[0], 9, direct() ? 1e-6 : 2e-3);
  world.set_pose(weights[0], {{-1, 0, 1}, Quaternion::Identity()});
  const double before = world.velocity(weights[1]).z();
  world.step(dt);
  EXPECT_NEAR(world.velocity(weights[1]).z(), before - g * dt, 1e-7) << "nothing pulls by a slack rope";
}

INSTANTIATE_TEST_SUITE_P(Solvers, TendonTest, testing::Values(JointSolver::Iterative, JointSolver::Direct),
                         [](const auto& solver) { return solver_name(solver.param); });

// Both solve the same problem: what they differ by shrinks with the substeps.
TEST(Tendon, BothSolversConvergeToTheSameMotion) {
  const auto run_with = [](JointSolver solver, int substeps) {
    Rotors rotors(3, solver, substeps);
    rotors.world.add_joint({.kind = TendonJoint{.terms = {{.joint = rotors.hinges[0], .polynomial = {0, 1, 0.4}},
                                                          {.joint = rotors.hinges[1], .polynomial = {0, -2}},
                                                          {.joint = rotors.hinges[2], .polynomial = {0, 0.5, 0, 0.3}}},
                                                .length = {.spring = JointSpring{.stiffness = 30, .damping = 1}}}});
    rotors.world.set_velocity(rotors.cubes[0], Vector3::Zero(), {0, 0, 2});
    run(rotors.world, 60);
    return Vector3(rotors.angle(0), rotors.angle(1), rotors.angle(2));
  };
  const Vector3 exact = run_with(JointSolver::Direct, 64);
  const double coarse = (run_with(JointSolver::Iterative, 4) - exact).norm();
  const double fine = (run_with(JointSolver::Iterative, 32) - exact).norm();
  EXPECT_LT(fine, 0.25 * coarse);
  EXPECT_LT(fine, 5e-3);
  EXPECT_LT((run_with(JointSolver::Direct, 4) - exact).norm(), 5e-3);
}

}  // namespace
}  // namespace atl::test::tendon_test
