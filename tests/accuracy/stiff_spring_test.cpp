// A spring along a joint's coordinate, of any stiffness: as its closed form has it where substeps can follow, and at
// rest where they can't.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "support/bodies.h"
#include "support/joined_run.h"

namespace atl::test::stiff_spring_test {
namespace {

struct StiffSpring {
  bool slider;  ///< else along the distance of two points
  bool linear;  ///< said in N/m, else in hertz
  JointSolver solver;
};

class StiffSpringTest : public testing::TestWithParam<StiffSpring> {
 protected:
  static constexpr double amplitude = 0.1;  // m
  static constexpr int steps = 60;

  struct Swing {
    double error = 0;     // the largest of positions against the closed form, over the amplitude
    double farthest = 0;  // from rest, likewise
    double end = 0;       // in the last step
  };

  // `turn` rad a substep.
  Swing swing(double turn, double damping_ratio) const {
    const double h = substep();
    const double w = turn / h;
    const double mass = 3;
    const JointSpring spring = GetParam().linear
                                   ? JointSpring{.stiffness = mass * w * w, .damping = 2 * damping_ratio * mass * w}
                                   : JointSpring{.hertz = w / (2 * std::numbers::pi), .damping_ratio = damping_ratio};
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = GetParam().solver}});
    const BodyId hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    const double rest = GetParam().slider ? 0 : 2;
    const BodyId body = world.add_body(
        {.shape = Sphere{0.3}, .position = {rest + amplitude, 0, 0}, .mass = mass, .filter = {.mask = 0}});
    JointDef def = {.kind = SliderJoint{{.spring = spring}}, .first = hook, .second = body};
    if (!GetParam().slider) {
      JointSpring longer = spring;
      longer.rest = rest;
      def.kind = DistanceJoint{{.range = {}, .spring = longer}};
    }
    world.add_joint(def);

    const double damped = w * std::sqrt(1 - damping_ratio * damping_ratio);
    Swing result;
    for (int step = 1; step <= steps; ++step) {
      world.step(dt);
      const double t = step * dt;
      const double x =
          std::exp(-damping_ratio * w * t) * (std::cos(damped * t) + damping_ratio * w / damped * std::sin(damped * t));
      const double is = (world.pose(body).position.x() - rest) / amplitude;
      result.error = std::max(result.error, std::abs(is - x));
      result.farthest = std::max(result.farthest, std::abs(is));
      result.end = std::abs(is);
    }
    return result;
  }
};

TEST_P(StiffSpringTest, MovesAsItsClosedForm) {
  // Velocities are half a substep behind in joints that are swept.
  const bool direct = GetParam().solver == JointSolver::Direct;
  for (const double damping_ratio : {0.0, 0.5}) {
    for (const double turn : {0.01, 0.03, 0.1, 0.3, 0.9}) {
      const double limit = direct ? 0.2 * turn * turn : 0.6 * turn;
      EXPECT_LT(swing(turn, damping_ratio).error, limit + 3e-5) << "w h = " << turn << ", ratio " << damping_ratio;
    }
  }
}

TEST_P(StiffSpringTest, ComesToRestWhereSubstepsCannotFollow) {
  for (const double damping_ratio : {0.0, 0.5}) {
    for (const double turn : {3.0, 30.0, 1000.0}) {
      const Swing result = swing(turn, damping_ratio);
      EXPECT_LT(result.farthest, 1) << "w h = " << turn << ", ratio " << damping_ratio;
      EXPECT_LT(result.end, 1e-5) << "w h = " << turn << ", ratio " << damping_ratio;
    }
  }
}

// A spring along a coordinate, alone with a body, that turns or slides.
struct Sprung {
  World world;
  JointId joint;
  JointSolver solver;
  double turn;  // rad a substep
  double h;     // s

  // J/kg: the energy that the map of a substep keeps. Velocities of swept joints are half a substep behind.
  double energy() const {
    const double x = world.joint_state(joint).position[0], u = world.joint_state(joint).speed[0];
    const auto stiffness = [this](double sine) { return sine * sine / (h * h); };
    return solver == JointSolver::Direct ? 0.5 * (u * u + stiffness(std::sin(turn)) * x * x)
                                         : 0.5 * (u * u + stiffness(2 * std::sin(turn / 2)) * x * (x - h * u));
  }
};

// Starts at rest at 0.3 m or rad. `axis` gets its spring here.
Sprung sprung(JointSolver solver, bool turns, int substeps, double turn, JointAxis axis) {
  const double h = dt / substeps;
  axis.spring = JointSpring{.hertz = turn / h / (2 * std::numbers::pi), .damping_ratio = 0};
  World world({.gravity = Vector3::Zero(), .settings = {.substeps = substeps, .joint_solver = solver}});
  const BodyId hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
  BodyDef def = {.shape = Sphere{0.1}, .mass = 1, .filter = {.mask = 0}};
  if (turns) {
    def.orientation = Quaternion(Eigen::AngleAxisd(0.3, Vector3::UnitX()));
  } else {
    def.position = {0.3, 0, 0};
  }
  const BodyId body = world.add_body(def);
  const JointId joint = world.add_joint(
      {.kind = turns ? JointKind(HingeJoint{axis}) : JointKind(SliderJoint{axis}), .first = hook, .second = body});
  return {std::move(world), joint, solver, turn, h};
}

// Each bounce leaves the energy that the end's height and restitution say, however far a substep goes. With the force
// of the substep's start all along the way, or kicks that held what had bounced, such a body flew ever farther.
TEST(SprungBounces, LeaveWhatTheClosedFormSays) {
  constexpr double restitution = 0.9, end = 2.0 / 3;
  for (const JointSolver solver : {JointSolver::Direct, JointSolver::Iterative}) {
    for (const int substeps : {1, 4}) {
      for (const double turn : {0.1, 0.2, 0.4, 0.7}) {
        for (const bool turns : {false, true}) {
          Sprung run = sprung(solver, turns, substeps, turn,
                              {.range = {.lower = -0.3 * end, .upper = unlimited, .restitution = restitution}});
          run.world.step(1e-9);
          const double start = run.energy();
          double level = 1;
          int bounces = 0;
          for (int step = 0; step < 400 / substeps && bounces < 4; ++step) {
            run.world.step(dt);
            const double now = run.energy() / start;
            EXPECT_LT(now, 1.03 * level) << solver_name(solver) << substeps << " " << turn << " " << turns << " "
                                         << step;
            while (now < 0.97 * level && bounces < 4) {
              level = end * end + restitution * restitution * (level - end * end);
              ++bounces;
            }
            EXPECT_GT(now, 0.97 * level) << solver_name(solver) << substeps << " " << turn << " " << turns;
          }
          EXPECT_EQ(bounces, 4) << solver_name(solver) << substeps << " " << turn << " " << turns;
        }
      }
    }
  }
}

// A small ball at the end of an arm, on a spring or a servo that turns it: what the hinge holds is nearly all that moves.
void expect_closed_form_of_arm(JointSolver solver, double arm, double turn, bool servo) {
  const double w = turn / substep();
  World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = solver}});
  const BodyId hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
  const Quaternion start(Eigen::AngleAxisd(0.3, Vector3::UnitX()));
  const BodyId ball = world.add_body({.shape = Sphere{0.05},
                                      .position = start * Vector3(0, arm, 0),
                                      .orientation = start,
                                      .mass = 1,
                                      .filter = {.mask = 0}});
  const double stiffness = (0.4 * 0.05 * 0.05 + arm * arm) * w * w;
  JointAxis axis;
  if (servo) {
    axis.motor = JointMotor{.max_force = unlimited, .servo = JointServo{.stiffness = stiffness}};
  } else {
    axis.spring = JointSpring{.stiffness = stiffness};
  }
  const JointId joint = world.add_joint(
      {.kind = HingeJoint{axis}, .first = hook, .second = ball, .frame_second = {.position = {0, -arm, 0}}});
  double error = 0;
  for (int step = 1; step <= 60; ++step) {
    world.step(dt);
    error = std::max(error, std::abs(world.joint_state(joint).position[0] - 0.3 * std::cos(w * step * dt)));
  }
  const double limit = solver == JointSolver::Direct ? 1.5 * turn * turn : turn;
  EXPECT_LT(error, 0.3 * limit + 3e-5) << solver_name(solver) << " " << arm << " " << turn << " " << servo;
}

TEST(SprungArms, SwingAsTheClosedFormHasIt) {
  for (const JointSolver solver : {JointSolver::Direct, JointSolver::Iterative}) {
    for (const double arm : {0.0, 0.3, 1.5}) {
      for (const double turn : {0.03, 0.1, 0.3, 0.9}) {
        if (solver == JointSolver::Iterative && turn > 0.5) continue;  // where amplitudes are off, too
        for (const bool servo : {false, true}) expect_closed_form_of_arm(solver, arm, turn, servo);
      }
    }
  }
}

// A rotor on an undamped spring swings as far for ever: its coordinate moves by what its rate says, at any turn a
// substep.
TEST(SprungRotors, SwingAsFarForEver) {
  for (const bool turns : {false, true}) {
    for (const double turn : {0.1, 0.5, 0.9}) {
      for (const double armature : {0.0, 0.004, 1.0}) {
        Sprung run = sprung(JointSolver::Direct, turns, 4, turn, {.armature = armature});
        double late = 0;
        for (int step = 0; step < 1000; ++step) {
          run.world.step(dt);
          const double position = std::abs(run.world.joint_state(run.joint).position[0]);
          EXPECT_LT(position, 0.3 * (1 + 1e-3)) << turns << " " << turn << " " << armature << " " << step;
          if (step > 700) late = std::max(late, position);
        }
        EXPECT_GT(late, 0.3 * (1 - 1e-2)) << turns << " " << turn << " " << armature;
      }
    }
  }
}

// A box on a smooth floor, between a spring and an end of its range that bounces or is never reached.
class SprungOnTheGround : public testing::TestWithParam<std::tuple<ContactSolver, JointSolver>> {
 protected:
  // m: how far it gets in the last third of ten seconds, of 0.3 m.
  static double late_reach(double hertz, double armature, bool bounces) {
    const double stiffness = std::pow(2 * std::numbers::pi * hertz, 2);
    const auto [contacts, joints] = GetParam();
    World world({.settings = {.contact_solver = contacts, .joint_solver = joints}});
    BodyDef floor = static_box({0, 0, -0.5}, {20, 20, 0.5});
    BodyDef block = box({0.3, 0, 0.1}, Vector3::Constant(0.1));
    floor.material.friction = block.material.friction = 0;
    block.mass = 1;
    world.add_body(floor);
    const BodyId hook = world.add_body(
        {.type = BodyType::Static, .shape = Sphere{0.05}, .position = {0, 0, 0.1}, .filter = {.mask = 0}});
    const BodyId body = world.add_body(block);
    JointAxis axis{.spring = JointSpring{.stiffness = stiffness}, .armature = armature};
    if (bounces) axis.range = {.lower = -0.2, .upper = unlimited, .restitution = 0.9};
    world.add_joint({.kind = SliderJoint{axis}, .first = hook, .second = body});
    double reach = 0;
    for (int step = 0; step < 600; ++step) {
      world.step(dt);
      if (step >= 400) reach = std::max(reach, std::abs(world.pose(body).position.x()));
    }
    return reach;
  }
};

// The watch on energy takes a spring's as substeps keep it. By what it has now it would fluctuate within a swing, and
// what seems a gain be taken away: a spring of 8 Hz came to rest within seconds.
TEST_P(SprungOnTheGround, SwingsOn) {
  for (const double hertz : {2.0, 8.0, 20.0}) {
    for (const double armature : {0.0, 1.0}) {
      const double reach = late_reach(hertz, armature, false);
      EXPECT_GT(reach, 0.29) << hertz << " " << armature;
      EXPECT_LT(reach, 0.31) << hertz << " " << armature;
    }
  }
}

TEST_P(SprungOnTheGround, LosesWhatBouncesTake) {
  for (const double hertz : {2.0, 8.0, 20.0, 35.0}) {
    for (const double armature : {0.0, 1.0})
      EXPECT_LT(late_reach(hertz, armature, true), 0.22) << hertz << " " << armature;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, SprungOnTheGround,
                         testing::Combine(testing::Values(ContactSolver::Iterative, ContactSolver::Direct),
                                          testing::Values(JointSolver::Iterative, JointSolver::Direct)));

std::string name_of(const testing::TestParamInfo<StiffSpring>& spring) {
  return (spring.param.slider ? "Slider" : "Distance") + std::string(spring.param.linear ? "InNewtons" : "") +
         solver_name(spring.param.solver);
}

INSTANTIATE_TEST_SUITE_P(
    Springs, StiffSpringTest,
    testing::Values(StiffSpring{true, false, JointSolver::Direct}, StiffSpring{true, false, JointSolver::Iterative},
                    StiffSpring{false, false, JointSolver::Direct}, StiffSpring{false, false, JointSolver::Iterative},
                    StiffSpring{true, true, JointSolver::Direct}, StiffSpring{true, true, JointSolver::Iterative}),
    name_of);

}  // namespace
}  // namespace atl::test::stiff_spring_test
