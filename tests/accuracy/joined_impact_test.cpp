// Impacts on bodies that joints hold: what hangs together with them answers, by the inertia that it has where it is
// hit.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support/bodies.h"

namespace atl::test::joined_impact_test {
namespace {

struct Solver {
  JointSolver joints;
  ContactSolver contacts;
  int substeps;
};

std::vector<Solver> solvers() {
  std::vector<Solver> all;
  for (const JointSolver joints : {JointSolver::Auto, JointSolver::Iterative, JointSolver::Direct}) {
    for (const ContactSolver contacts : {ContactSolver::Auto, ContactSolver::Direct}) {
      for (const int substeps : {1, 4, 16}) all.push_back({joints, contacts, substeps});
    }
  }
  return all;
}

WorldDef floating(const Solver& solver) {
  return {.gravity = Vector3::Zero(),
          .settings = {.substeps = solver.substeps, .contact_solver = solver.contacts, .joint_solver = solver.joints}};
}

std::string name(const Solver& solver) {
  return std::to_string(static_cast<int>(solver.joints)) + " " + std::to_string(static_cast<int>(solver.contacts)) +
         " " + std::to_string(solver.substeps);
}

constexpr double door_mass = 6, ball_mass = 1, speed = 4;  // kg, kg, m/s
const Vector3 door_size(0.5, 0.03, 0.5);

BodyDef elastic(BodyDef def, double mass, double restitution = 1) {
  def.mass = mass;
  def.material = {.friction = 0, .restitution = restitution};
  return def;
}

BodyId throw_ball(World& world, double x) {
  BodyDef def = elastic(sphere({x, -0.5, 0}, 0.1), ball_mass, 0);
  def.velocity = {0, speed, 0};
  return world.add_body(def);
}

// m/s, with which a ball comes back from something that answers by 1 / `inertia` where it is hit.
double thrown_back(double inertia, double restitution) {
  return speed - (1 + restitution) * speed / (1 + ball_mass / inertia);
}

const double about_hinge = box_inertia(door_mass, door_size).z() + door_mass * door_size.x() * door_size.x();

BodyId add_door(World& world, double restitution, const JointRange& range = {}) {
  BodyDef post = static_box({-0.5, 0, 0}, door_size);
  post.filter = {.mask = 0};
  const BodyId fixed = world.add_body(post);
  const BodyId door = world.add_body(elastic(box({door_size.x(), 0, 0}, door_size), door_mass, restitution));
  HingeJoint hinge;
  hinge.angle.range = range;
  world.add_joint(joint_at(world, hinge, fixed, door, Vector3::Zero(), Vector3::UnitZ()));
  return door;
}

TEST(JoinedImpact, ADoorAnswersByItsInertiaAboutTheHinge) {
  for (const Solver& solver : solvers()) {
    for (const double at : {0.2, 0.5, 0.9}) {
      for (const double restitution : {0.5, 1.0}) {
        World world(floating(solver));
        const BodyId door = add_door(world, restitution);
        const BodyId ball = throw_ball(world, at);
        run(world, 12);
        const double back = thrown_back(about_hinge / (at * at), restitution);
        EXPECT_NEAR(world.velocity(ball).y(), back, 1e-3 * speed) << name(solver) << " " << at;
        EXPECT_NEAR(world.angular_velocity(door).z(), ball_mass * (speed - back) * at / about_hinge, 1e-2)
            << name(solver) << " " << at;
      }
    }
  }
}

TEST(JoinedImpact, ADoorAtItsStopDoesNotAnswer) {
  for (const Solver& solver : solvers()) {
    World world(floating(solver));
    const BodyId door = add_door(world, 1, {.lower = -1, .upper = 0});
    const BodyId ball = throw_ball(world, 0.5);
    run(world, 12);
    EXPECT_NEAR(world.velocity(ball).y(), -speed, 1e-3 * speed) << name(solver);
    EXPECT_NEAR(world.angular_velocity(door).z(), 0, 1e-3) << name(solver);
  }
}

TEST(JoinedImpact, BodiesThatAreFixedTogetherBounceAsOne) {
  for (const Solver& solver : solvers()) {
    for (const double restitution : {0.5, 1.0}) {
      World world(floating(solver));
      world.add_body(ground(0));
      BodyDef below = elastic(sphere({0, 0, 0.31}, 0.1), 1, restitution);
      BodyDef above = elastic(sphere({0, 0, 0.61}, 0.1), 4, restitution);
      below.velocity = above.velocity = {0, 0, -1};
      const BodyId a = world.add_body(below), b = world.add_body(above);
      world.add_joint(joint_at(world, FixedJoint{}, a, b, {0, 0, 0.45}, Vector3::UnitZ()));
      run(world, 30);
      for (const BodyId body : {a, b}) EXPECT_NEAR(world.velocity(body).z(), restitution, 1e-4) << name(solver);
    }
  }
}

// A chain of boxes that turns as one, and is struck off its centre.
TEST(JoinedImpact, ChainsKeepTheirMomentumAndMakeNoEnergy) {
  const Vector3 size(0.25, 0.1, 0.1);
  for (const Solver& solver : solvers()) {
    World world(floating(solver));
    std::vector<BodyId> bodies;
    for (int i = 0; i < 4; ++i) {
      BodyDef link = elastic(box({0.5 * i, 0, 0}, size), 1 + i, 1);
      link.velocity = {0, 0.5 * i - 0.75, 0};
      link.angular_velocity = {0, 0, 1};
      bodies.push_back(world.add_body(link));
      if (i == 0) continue;
      world.add_joint(joint_at(world, BallJoint{}, bodies[bodies.size() - 2], bodies.back(), {0.5 * i - 0.25, 0, 0}));
    }
    bodies.push_back(throw_ball(world, 0.6));
    const auto energy = [&] {
      double sum = kinetic_energy(world, bodies);
      for (std::size_t i = 0; i < 4; ++i) {
        const double spin = world.angular_velocity(bodies[i]).z();
        sum += 0.5 * box_inertia(world.mass(bodies[i]), size).z() * spin * spin;
      }
      return sum;
    };
    const double energy_before = energy();
    const Vector3 before = momentum(world, bodies);
    run(world, 12);
    EXPECT_LT(world.velocity(bodies.back()).y(), 0.5 * speed) << name(solver);
    EXPECT_LT((momentum(world, bodies) - before).norm(), 1e-5 * before.norm()) << name(solver);
    EXPECT_LE(energy(), (1 + 1e-4) * energy_before) << name(solver);
    EXPECT_GE(energy(), (1 - 2e-2) * energy_before) << name(solver);  // joints lose some with one substep
  }
}

}  // namespace
}  // namespace atl::test::joined_impact_test
