// A spring along a joint's coordinate, of any stiffness: as its closed form has it where substeps can follow, and at
// rest where they can't.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

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
