// Atoll's own error in the scenes with a closed form, at the scenes' settings unless stated, and how it falls. h is a
// substep, 1/240 s at the defaults, dt a step.

#include <cmath>

#include "support/closed_form_run.h"

namespace atl::test::analytic_scene_test {
namespace {

Settings substeps(int count) { return {.substeps = count}; }

double error(std::string_view scene, const Settings& settings = {}, double step = dt) {
  return run_closed_form(scene, settings, step).at("analytic_error");
}

TEST(AnalyticScene, FreeFlightIsExact) {
  for (const double step : {dt, dt / 4}) EXPECT_LT(error("free-flight", {}, step), 1e-12) << step;
}

TEST(AnalyticScene, TopsKeepMomentumAndEnergyAndTurnAsTheyShould) {
  for (const char* scene : {"spinning-top", "spinning-top:tilt=0.01", "spinning-top:spin=8"}) {
    const Errors four = run_closed_form(scene, substeps(4)), eight = run_closed_form(scene, substeps(8));
    EXPECT_LT(four.at("momentum_error"), 1e-10) << scene;
    EXPECT_LT(four.at("energy_error"), 1e-7) << scene;
    EXPECT_LT(four.at("analytic_error"), 1e-4) << scene;
    EXPECT_LT(eight.at("analytic_error"), four.at("analytic_error") / 10 + 1e-10) << scene << ": fourth order";
  }
}

// Nothing pushes the top sideways. Where its tip presses on the ground, as seen from its centre, is that of the start
// of a step: of first order in the step.
TEST(AnalyticScene, HeavyTopPrecesses) {
  EXPECT_LT(run_closed_form("heavy-top", {}).at("centre_drift"), 1e-6);
  const double coarse = error("heavy-top", {}), fine = error("heavy-top", {}, dt / 4);
  EXPECT_LT(coarse, 0.3);
  EXPECT_LT(fine, 0.4 * coarse);
  EXPECT_LT(error("heavy-top", {}, dt / 16), 0.4 * fine);
}

// Steady braking is followed exactly; what is left is the substep in which a block stops, mu g h^2 at most, and the
// give of the contact as it takes up the load.
TEST(AnalyticScene, BlocksSlideStraightInAllDirections) {
  const Errors errors = run_closed_form("sliding-blocks", {});
  EXPECT_LT(errors.at("lateral_drift"), 1e-5);
  EXPECT_LT(errors.at("analytic_error"), 5e-5);
}

// Inside a circular cone a pyramid's friction across the axes is too strong by up to sqrt(2).
TEST(AnalyticScene, APyramidBendsTheirPaths) {
  EXPECT_GT(run_closed_form("sliding-blocks:headings=24", {.friction = FrictionModel::Pyramid}).at("lateral_drift"),
            0.05);
}

TEST(AnalyticScene, BlocksHoldAndSlideOnASlope) { EXPECT_LT(error("incline"), 2e-5); }

TEST(AnalyticScene, SpheresRoll) {
  const Errors launched = run_closed_form("rolling-sphere", {});
  EXPECT_LT(launched.at("analytic_error"), 1e-4);
  EXPECT_LT(launched.at("lateral_drift"), 1e-5);
  EXPECT_LT(error("incline-sphere"), 1e-4);
}

// A body that stops within a substep may stop a substep late.
TEST(AnalyticScene, RollingFrictionStopsSpheresInAllDirections) {
  for (const char* scene : {"rolling-resistance", "rolling-resistance:rolling_friction=0.01,speed=1"}) {
    const Errors errors = run_closed_form(scene, {});
    EXPECT_LT(errors.at("analytic_error"), 1e-3) << scene;
    EXPECT_LT(errors.at("lateral_drift"), 1e-4) << scene;
    EXPECT_LT(errors.at("speed_error"), 2e-3) << scene;
    EXPECT_LT(errors.at("spin_error"), 2e-3) << scene;
  }
}

TEST(AnalyticScene, TorsionalFrictionStopsSpins) {
  for (const char* scene : {"torsion", "torsion:spin=1,torsional_friction=0.002"}) {
    const Errors errors = run_closed_form(scene, {});
    EXPECT_LT(errors.at("analytic_error"), 1e-3) << scene;
    EXPECT_LT(errors.at("spin_error"), 5e-3) << scene;
    EXPECT_LT(errors.at("drift"), 1e-4) << scene;
  }
}

// The balls press the box unevenly as they fall behind, which tilts it by the give of its contacts.
TEST(AnalyticScene, PushedBoxCarriesItsBalls) {
  for (const char* scene : {"pushed-box", "pushed-box:angle=0"}) {
    EXPECT_LT(error(scene), 3e-4) << scene;
    EXPECT_LT(run_closed_form(scene, {}).at("lateral_drift"), 1e-4) << scene;
  }
}

// A manifold is made once a step, so an edge moves under the block by what it turns in one.
TEST(AnalyticScene, TippingBlocksHoldAndTip) {
  const Errors errors = run_closed_form("tipping-block", {});
  EXPECT_LT(errors.at("hold_error"), 1e-3);
  EXPECT_LT(errors.at("tip_error"), 0.12);
  EXPECT_LT(error("tipping-block", {}, dt / 4), 0.03);
  EXPECT_LT(error("tipping-block", {}, dt / 16), 0.005);
}

// Landings have substeps of their own: they take place where a substep finds them, up to v h away from where they
// should.
TEST(AnalyticScene, RockingBlockFollowsHousner) {
  EXPECT_LT(error("rocking-block"), 0.05);
  EXPECT_LT(error("rocking-block", {}, dt / 4), 0.006);
  EXPECT_LT(error("rocking-block", {}, dt / 16), 0.01);
}

// The speed of an impact is that of its instant, wherever in a step that lies.
TEST(AnalyticScene, BallBouncesToTheRightHeight) {
  for (const double step : {dt, dt / 16}) EXPECT_LT(error("bouncing-ball", {}, step), 1e-4) << step;
}

TEST(AnalyticScene, BallWithoutLossKeepsItsEnergy) {
  const Errors errors = run_closed_form("elastic-ball", {});
  EXPECT_LT(errors.at("energy_gain"), 1e-4);
  EXPECT_LT(errors.at("energy_loss"), 1e-4);
}

TEST(AnalyticScene, PairsExchangeMomentumWithoutLoss) {
  const Errors errors = run_closed_form("elastic-pair", {});
  EXPECT_LT(errors.at("analytic_error"), 1e-5);
  EXPECT_LT(errors.at("momentum_error"), 1e-5);
  EXPECT_LT(errors.at("energy_error"), 1e-5);
  EXPECT_LT(error("elastic-pair:offset=0.9", {}, 1.0 / 20), 1e-5);
}

// The gaps take 1/200 s each; impacts wait for each other, whatever the step.
TEST(AnalyticScene, CradleHandsOn) {
  for (const double step : {1.0 / 30, dt, dt / 4}) EXPECT_LT(error("cradle", {}, step), 1e-5) << step;
  EXPECT_LT(error("cradle:count=12"), 1e-4);
}

TEST(AnalyticScene, TowerCarriesItsWeight) {
  EXPECT_LT(error("stack-forces"), 1e-3);
  EXPECT_LT(error("stack-forces", substeps(8)), 1e-4);
  EXPECT_LT(error("stack-forces:height=4,ratio=5"), 1e-3);
}

}  // namespace
}  // namespace atl::test::analytic_scene_test
