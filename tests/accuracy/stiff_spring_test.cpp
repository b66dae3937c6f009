// A spring along a joint's coordinate, of any stiffness: implicit Euler in each substep, to the precision of floats.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "support/joined_run.h"

namespace atl::test {
namespace {

struct StiffSpring {
  bool slider;  ///< else along the distance of two points
  JointSolver solver;
};

class StiffSpringTest : public testing::TestWithParam<StiffSpring> {
 protected:
  static constexpr double amplitude = 0.1;  // m
  static constexpr int steps = 60;

  // The largest error of positions, over the amplitude, and of speeds, over what they can come to.
  double error(double turn, double damping_ratio) const {
    const double h = substep();
    const double w = turn / h;
    const JointSpring spring = {.hertz = w / (2 * std::numbers::pi), .damping_ratio = damping_ratio, .rest = 0};
    World world({.gravity = Vector3::Zero(), .settings = {.joint_solver = GetParam().solver}});
    const BodyId hook = world.add_body({.type = BodyType::Static, .shape = Sphere{0.1}});
    const double rest = GetParam().slider ? 0 : 2;
    const BodyId body =
        world.add_body({.shape = Sphere{0.3}, .position = {rest + amplitude, 0, 0}, .mass = 3, .filter = {.mask = 0}});
    JointDef def = {.kind = SliderJoint{{.spring = spring}}, .first = hook, .second = body};
    if (!GetParam().slider) {
      JointSpring longer = spring;
      longer.rest = rest;
      def.kind = DistanceJoint{{.range = {}, .spring = longer}};
    }
    world.add_joint(def);

    double x = amplitude, v = 0, worst = 0;
    for (int step = 0; step < steps; ++step) {
      world.step(dt);
      for (int i = 0; i < Settings().substeps; ++i) {
        v = (v - h * w * w * x) / (1 + 2 * damping_ratio * turn + turn * turn);
        x += h * v;
      }
      const Vector3 position = world.pose(body).position - Vector3(rest, 0, 0);
      worst = std::max(worst, (position - Vector3(x, 0, 0)).norm() / amplitude);
      worst = std::max(worst, (world.velocity(body) - Vector3(v, 0, 0)).norm() / (amplitude * std::min(w, 1 / h)));
    }
    return worst;
  }
};

TEST_P(StiffSpringTest, IsSolvedImplicitly) {
  for (const double turn : {0.01, 0.1, 1.0, 10.0, 100.0, 1000.0}) {
    for (const double damping_ratio : {0.0, 0.5}) {
      const double worst = error(turn, damping_ratio);
      EXPECT_LT(worst, 1e-5) << "w h = " << turn << ", damping ratio " << damping_ratio;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Springs, StiffSpringTest,
                         testing::Values(StiffSpring{true, JointSolver::Direct},
                                         StiffSpring{true, JointSolver::Iterative},
                                         StiffSpring{false, JointSolver::Direct},
                                         StiffSpring{false, JointSolver::Iterative}),
                         [](const auto& spring) {
                           return (spring.param.slider ? "Slider" : "Distance") + solver_name(spring.param.solver);
                         });

}  // namespace
}  // namespace atl::test
