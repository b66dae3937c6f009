// Atoll's own error in the scenes with joints whose motion is known, by both solvers, and how it falls with the step.
// With few joints both are run at little cost.

#include <cmath>

#include "support/closed_form_run.h"

namespace atl::test::analytic_joint_test {
namespace {

Errors direct(std::string_view scene, double step = dt) {
  return run_closed_form(scene, {.joint_solver = JointSolver::Direct}, step);
}
Errors iterative(std::string_view scene, double step = dt) {
  return run_closed_form(scene, {.joint_solver = JointSolver::Iterative}, step);
}

// One after the other joints act along where they were as a substep began, which is of first order and loses energy.
TEST(AnalyticJoint, PendulumSwings) {
  EXPECT_LT(direct("pendulum").at("analytic_error"), 2e-3);
  EXPECT_LT(direct("pendulum").at("energy_drift"), 2e-4);
  EXPECT_LT(direct("pendulum", dt / 4).at("analytic_error"), 1e-4);
  EXPECT_LT(direct("pendulum:angle=0.5").at("analytic_error"), 4e-3);
  EXPECT_LT(direct("pendulum:angle=0.5", dt / 4).at("analytic_error"), 3e-4);

  const double coarse = iterative("pendulum:angle=0.5").at("analytic_error");
  EXPECT_LT(coarse, 0.2);
  EXPECT_LT(iterative("pendulum:angle=0.5", dt / 4).at("analytic_error"), 0.3 * coarse);
  for (const Errors& errors : {direct("pendulum"), iterative("pendulum")}) EXPECT_LT(errors.at("off_plane"), 1e-12);
}

TEST(AnalyticJoint, DoublePendulumFollowsItsEquations) {
  EXPECT_LT(direct("double-pendulum").at("analytic_error"), 2e-3);
  EXPECT_LT(direct("double-pendulum", dt / 4).at("analytic_error"), 2e-4);
  const double coarse = iterative("double-pendulum").at("analytic_error");
  EXPECT_LT(coarse, 0.15);
  EXPECT_LT(iterative("double-pendulum", dt / 4).at("analytic_error"), 0.3 * coarse);
}

// A loop of joints that holds nothing twice, driven through its dead centres.
TEST(AnalyticJoint, CrankMovesTheSlider) {
  EXPECT_LT(direct("slider-crank").at("analytic_error"), 1e-5);
  EXPECT_LT(direct("slider-crank").at("closure_error"), 3e-6);
  const Errors coarse = iterative("slider-crank"), fine = iterative("slider-crank", dt / 4);
  EXPECT_LT(coarse.at("analytic_error"), 0.012);
  EXPECT_LT(coarse.at("closure_error"), 0.005);
  EXPECT_LT(fine.at("analytic_error"), 0.0015);
  EXPECT_LT(fine.at("closure_error"), 0.1 * coarse.at("closure_error")) << "second order";
}

// Implicit Euler damps what has no damping of its own, the faster the more: w h / 2 of critical.
TEST(AnalyticJoint, SpringsOscillate) {
  for (const auto& [name, error] : direct("spring-damper", dt)) {
    if (name.ends_with("_error") && !name.starts_with("joint")) {
      EXPECT_LT(error, 1e-4) << name;
    }
  }
  // Swept ones' velocities are half a substep behind.
  const Errors coarse = iterative("spring-damper", dt), fine = iterative("spring-damper", dt / 4);
  for (const char* name :
       {"undamped_error", "underdamped_error", "critical_error", "overdamped_error", "distance_error"}) {
    EXPECT_LT(coarse.at(name), 0.02) << name;
    EXPECT_LT(fine.at(name), 0.35 * coarse.at(name)) << name;
  }
}

TEST(AnalyticJoint, ChainsAtRestStay) {
  for (const char* scene : {"hanging-chain", "hanging-chain:ratio=100000", "hanging-chain:links=200"}) {
    EXPECT_LT(direct(scene).at("analytic_error"), 1e-10) << scene;
    EXPECT_LT(direct(scene).at("joint_gap_run_max"), 1e-10) << scene;
  }
  EXPECT_LT(direct("catenary").at("analytic_error"), 1e-6);
  // The stretch under load falls with the square of the step.
  for (const char* scene : {"hanging-chain", "catenary"}) {
    const double coarse = iterative(scene).at("analytic_error");
    EXPECT_LT(coarse, 0.1) << scene;
    EXPECT_LT(iterative(scene, dt / 4).at("analytic_error"), 0.1 * coarse) << scene;
  }
}

/// Forces of the joints of a chain at rest, over the weight that hangs on them: the largest error.
double tension_error(const Settings& settings, int links, double ratio) {
  const Scene scene = load_scene("hanging-chain:links=" + std::to_string(links) + ",ratio=" + std::to_string(ratio));
  World world({.gravity = scene.gravity, .settings = settings});
  std::vector<JointId> joints;
  build_scene(scene, world, joints);
  for (int step = 0; step < 120; ++step) world.step(dt);
  double largest = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double weight = g * (ratio + static_cast<double>(links) - static_cast<double>(i));
    // On the lower of the two bodies, which is the second.
    const Vector3 force = world.joint_state(joints[i]).force;
    largest = std::max(largest, (force - Vector3(0, 0, weight)).norm() / weight);
  }
  return largest;
}

TEST(AnalyticJoint, ChainCarriesWhatHangsOnIt) {
  for (const double ratio : {1.0, 100.0, 1e5}) {
    EXPECT_LT(tension_error({.joint_solver = JointSolver::Direct}, 20, ratio), 1e-6) << ratio;
  }
  EXPECT_LT(tension_error({.joint_solver = JointSolver::Iterative}, 20, 1), 0.1);
}

}  // namespace
}  // namespace atl::test::analytic_joint_test
