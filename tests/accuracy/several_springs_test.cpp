// Springs, servos and ends of ranges on several rows that act on one motion: as they do on one row.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/joined_run.h"

namespace atl::test::several_springs_test {
namespace {

constexpr double start = 0.1;  // m, from where springs rest
constexpr int steps = 60;

// Touching ground, contacts are solved together with joints, or swept in turns with them.
enum class Kind { SixDofs, Tendons, TouchingGround, TouchingInTurns };

std::string name_of(Kind kind) {
  return kind == Kind::SixDofs          ? "six-dofs"
         : kind == Kind::Tendons        ? "tendons"
         : kind == Kind::TouchingGround ? "touching ground"
                                        : "touching in turns";
}

// m: a ball of 1 kg, step by step, between springs along x that together swing it by `turn` rad a substep.
std::vector<double> positions(Kind kind, JointSolver solver, int springs, double turn) {
  const bool touches = kind != Kind::SixDofs && kind != Kind::Tendons;
  Settings settings = {.joint_solver = solver};
  if (kind == Kind::TouchingInTurns) settings.contact_solver = ContactSolver::Iterative;
  World world({.gravity = touches ? Vector3(0, 0, -9.81) : Vector3(0, 0, 0), .settings = settings});
  const BodyId ground = world.add_body(
      {.type = BodyType::Static, .shape = HalfSpace{}, .position = {0, 0, -0.1}, .material = {.friction = 0}});
  BodyDef def = {.shape = Sphere{0.1}, .position = {start, 0, 0}, .mass = 1, .material = {.friction = 0}};
  if (!touches) def.filter.mask = 0;
  const BodyId ball = world.add_body(def);
  const double w = turn / substep();
  const JointAxis sprung = {.spring = JointSpring{.stiffness = w * w / springs}};
  JointDef joint = {.kind = SliderJoint{}, .first = ground, .second = ball};
  joint.frame_first.position = {0, 0, 0.1};
  if (kind == Kind::Tendons) {
    const JointId slider = world.add_joint(joint);
    for (int i = 0; i < springs; ++i) {
      world.add_joint({.kind = TendonJoint{.terms = {{.joint = slider}}, .length = sprung}});
    }
  } else {
    joint.kind = SixDofJoint{.offset = {sprung, JointAxis{}, JointAxis{}}};
    joint.collide = true;
    for (int i = 0; i < springs; ++i) world.add_joint(joint);
  }
  std::vector<double> found;
  for (int step = 0; step < steps; ++step) {
    world.step(dt);
    EXPECT_TRUE(world.quarantined().empty()) << name_of(kind) << " " << springs << " " << turn;
    found.push_back(world.pose(ball).position.x());
  }
  return found;
}

double furthest(const std::vector<double>& of) {
  double max = 0;
  for (const double x : of) max = std::max(max, std::abs(x));
  return max;
}

// Substeps can follow each spring by itself. Where they couldn't follow all together, these swung the ball ever
// farther, and eight lost it.
TEST(SeveralSprings, SideBySideActAsOne) {
  for (const Kind kind : {Kind::SixDofs, Kind::Tendons}) {
    for (const double turn : {0.1, 0.3, 0.9, 1.2, 2.5, 10.0}) {
      const std::vector<double> one = positions(kind, JointSolver::Direct, 1, turn);
      for (const int springs : {2, 8, 16}) {
        const std::vector<double> several = positions(kind, JointSolver::Direct, springs, turn);
        for (int step = 0; step < steps; ++step) {
          const auto at = static_cast<std::size_t>(step);
          EXPECT_NEAR(several[at], one[at], (turn < 1 ? 0.4 * turn * turn : 1e-6) * start)
              << name_of(kind) << " " << springs << " " << turn << " " << step;
        }
      }
    }
  }
}

TEST(SeveralSprings, NeverSwingABodyFarther) {
  for (const Kind kind : {Kind::SixDofs, Kind::Tendons, Kind::TouchingGround, Kind::TouchingInTurns}) {
    for (const JointSolver solver : {JointSolver::Auto, JointSolver::Direct, JointSolver::Iterative}) {
      for (const int springs : {2, 4, 8, 16}) {
        for (const double turn : {0.3, 1.0, 2.0, 4.0, 20.0}) {
          // Velocities are half a substep late beside contacts, and as the ball starts at rest it gains that.
          const bool late = kind != Kind::SixDofs && kind != Kind::Tendons && turn <= 1;
          const double most = late ? 1 / std::cos(turn / 2) : 1;
          EXPECT_LT(furthest(positions(kind, solver, springs, turn)), 1.05 * most * start)
              << name_of(kind) << " " << solver_name(solver) << " " << springs << " " << turn;
        }
      }
    }
  }
}

enum class Rows { Same, RangeOnATendon, SpringOnATendon };

// J, at the end of each step: a ball of 1 kg that bounces at the end of a range, on a spring of `turn` rad a substep.
std::vector<double> energies_of_bounces(Rows rows, double turn) {
  World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = JointSolver::Direct}});
  const BodyId hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
  const BodyId ball = world.add_body({.shape = Sphere{0.1}, .mass = 1, .filter = {.mask = 0}});
  const double w = turn / substep(), rest = 0.5;
  const JointAxis sprung = {.spring = JointSpring{.rest = rest, .stiffness = w * w}};
  const JointRange range = {.upper = 0.1, .restitution = 0.9};
  SliderJoint slider;
  if (rows != Rows::SpringOnATendon) slider.offset = sprung;
  if (rows != Rows::RangeOnATendon) slider.offset.range = range;
  const JointId joint = world.add_joint({.kind = slider, .first = hook, .second = ball});
  if (rows != Rows::Same) {
    const JointAxis length = rows == Rows::RangeOnATendon ? JointAxis{.range = range} : sprung;
    world.add_joint({.kind = TendonJoint{.terms = {{.joint = joint}}, .length = length}});
  }
  world.set_velocity(ball, {-1, 0, 0}, {0, 0, 0});
  std::vector<double> found;
  for (int step = 0; step < steps; ++step) {
    world.step(dt);
    const double from_rest = world.pose(ball).position.x() - rest;
    found.push_back(0.5 * (world.velocity(ball).squaredNorm() + w * w * from_rest * from_rest));
  }
  return found;
}

// A spring slows the ball down on its way to the end, whichever row has it.
TEST(SeveralSprings, BounceAtAnEndAsOnOneRow) {
  for (const double turn : {0.05, 0.2, 0.5}) {
    const std::vector<double> one = energies_of_bounces(Rows::Same, turn);
    for (const Rows rows : {Rows::RangeOnATendon, Rows::SpringOnATendon}) {
      const std::vector<double> several = energies_of_bounces(rows, turn);
      for (std::size_t step = 0; step < one.size(); ++step) {
        EXPECT_NEAR(several[step], one[step], 1e-6 * one.front()) << turn << " " << step;
      }
    }
  }
}

// A servo far from its target gives all it has, however stiff it is: a constant force beside the spring, which swings
// as before. Taken for a spring, it kept this one's velocities half a substep late.
TEST(SeveralSprings, KeepEnergyBesideAServoThatGivesAllItHas) {
  for (const double turn : {0.03, 0.1, 0.3}) {
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = JointSolver::Direct}});
    const BodyId hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    const BodyId ball =
        world.add_body({.shape = Sphere{0.1}, .position = {start, 0, 0}, .mass = 1, .filter = {.mask = 0}});
    const double w = turn / substep(), shift = 0.03 * start;
    JointAxis axis = {.spring = JointSpring{.stiffness = w * w}};
    axis.motor = JointMotor{.max_force = shift * w * w, .servo = JointServo{.target = 10, .stiffness = 1e6}};
    world.add_joint({.kind = SliderJoint{axis}, .first = hook, .second = ball});
    const auto energy = [&] {
      const double from_rest = world.pose(ball).position.x() - shift;
      return 0.5 * (world.velocity(ball).squaredNorm() + w * w * from_rest * from_rest);
    };
    world.step(dt);  // at whose start nobody knows where the servo is
    const double before = energy();
    for (int step = 1; step <= steps; ++step) {
      world.step(dt);
      EXPECT_NEAR(energy(), before, (0.1 * turn + 0.5 * turn * turn) * before) << turn << " " << step;
    }
  }
}

}  // namespace
}  // namespace atl::test::several_springs_test
