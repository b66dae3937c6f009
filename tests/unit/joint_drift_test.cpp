// Drift of joints, against values computed by hand.

#include <atoll/error_meter.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "support/expect_error.h"

namespace atl::test::joint_drift_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double exact = 1e-12;

Quaternion turned(double angle, const Vector3& axis) { return Quaternion(Eigen::AngleAxisd(angle, axis)); }

/// The drift of a joint whose first frame lies at the world's origin, along its axes, and whose second frame lies at
/// the pose.
JointDriftReport drift_at(const JointKind& kind, const Vector3& position, const Quaternion& orientation) {
  // Both frames away from those of their bodies, so that frames are told from bodies.
  const Pose local_first = {{1, 2, 3}, turned(0.7, Vector3(1, 1, 0).normalized())};
  const Pose local_second = {{-2, 0.5, 1}, turned(-1.1, Vector3(0, 1, 2).normalized())};
  const auto body_under = [](const Pose& frame, const Pose& local) {
    BodyState state;
    state.pose.orientation = frame.orientation * local.orientation.conjugate();
    state.pose.position = frame.position - state.pose.orientation * local.position;
    return state;
  };
  const std::vector<BodyState> states = {body_under({}, local_first),
                                         body_under({position, orientation}, local_second)};
  const PlacedJoint joint = {kind, 0, 1, local_first, local_second};
  return measure_joint_drift(std::span(&joint, 1), states);
}

JointDriftReport drift_at(const JointKind& kind, const Vector3& position) {
  return drift_at(kind, position, Quaternion::Identity());
}

TEST(JointDrift, IsNoneWhereAllHolds) {
  const JointAxis locked = {.range = {0, 0}};
  const std::vector<JointKind> kinds = {BallJoint{},
                                        HingeJoint{locked},
                                        SliderJoint{locked},
                                        FixedJoint{},
                                        UniversalJoint{locked, locked},
                                        ConeTwistJoint{0.1, locked},
                                        GearJoint{},
                                        WheelJoint{locked, locked, locked},
                                        SixDofJoint{{locked, locked, locked}, {locked, locked, locked}}};
  for (const JointKind& kind : kinds) {
    SCOPED_TRACE(kind.index());
    const JointDriftReport report = drift_at(kind, Vector3::Zero());
    EXPECT_LT(report.max, exact);
    EXPECT_LT(report.angle_max, exact);
    EXPECT_EQ(report.excess_max, 0);
    EXPECT_LT(report.angle_excess_max, exact);
  }
}

TEST(JointDrift, IsTheDistanceOfOriginsThatAreHeldTogether) {
  for (const JointKind& kind :
       std::vector<JointKind>{BallJoint{}, HingeJoint{}, FixedJoint{}, UniversalJoint{}, ConeTwistJoint{}}) {
    EXPECT_NEAR(drift_at(kind, {0.02, -0.03, 0.06}).max, 0.07, exact) << kind.index();
  }
  EXPECT_EQ(drift_at(BallJoint{}, Vector3::Zero(), turned(2, Vector3::UnitY())).angles, 0u);
}

TEST(JointDrift, HingeKeepsItsAxesParallelAndItsAngleInRange) {
  const HingeJoint hinge = {.angle = {.range = {-0.5, 1}}};
  const auto at = [&](double angle, double tilt) {
    return drift_at(hinge, Vector3::Zero(), turned(tilt, Vector3::UnitZ()) * turned(angle, Vector3::UnitX()));
  };
  EXPECT_NEAR(at(0.3, 0.05).angle_max, 0.05, exact);
  EXPECT_EQ(at(0.3, 0).angle_excess_max, 0);
  EXPECT_NEAR(at(1.2, 0).angle_excess_max, 0.2, exact);
  EXPECT_NEAR(at(-0.6, 0).angle_excess_max, 0.1, exact);
  EXPECT_NEAR(at(-0.6 + 2 * pi, 0).angle_excess_max, 0.1, exact);
  // Nearer to the upper end the other way round.
  EXPECT_NEAR(at(1 + 2.5, 0).angle_excess_max, 2 * pi - 0.5 - 3.5, exact);
}

TEST(JointDrift, AnglesCountWhateverTheTurn) {
  const auto excess = [](const JointRange& range, double angle) {
    return drift_at(HingeJoint{.angle = {.range = range}}, Vector3::Zero(), turned(angle, Vector3::UnitX()))
        .angle_excess_max;
  };
  EXPECT_EQ(excess({3 * pi, 9 * pi}, 1), 0) << "some turn lies in a range of three";
  EXPECT_EQ(excess({2 * pi, 2 * pi + 1}, 0.5), 0);
  EXPECT_NEAR(excess({2 * pi, 2 * pi + 1}, 1.5), 0.5, exact);
  EXPECT_EQ(excess({20, unlimited}, 1), 0);
}

TEST(JointDrift, SliderKeepsToItsLine) {
  const SliderJoint slider = {.offset = {.range = {-0.1, 0.4}}};
  EXPECT_NEAR(drift_at(slider, {0.2, 0.03, -0.04}).max, 0.05, exact);
  EXPECT_EQ(drift_at(slider, {0.2, 0, 0}).excess_max, 0);
  EXPECT_NEAR(drift_at(slider, {0.7, 0, 0}).excess_max, 0.3, exact);
  EXPECT_NEAR(drift_at(slider, {-0.3, 0, 0}).excess_max, 0.2, exact);
  EXPECT_NEAR(drift_at(slider, {0, 0, 0}, turned(0.1, Vector3::UnitX())).angle_max, 0.1, exact);
  EXPECT_NEAR(drift_at(slider, {0, 0, 0}, turned(0.1, Vector3::UnitY())).angle_max, 0.1, exact);
  EXPECT_EQ(drift_at(SliderJoint{}, {7, 0, 0}).max, 0);
  EXPECT_EQ(drift_at(SliderJoint{}, {7, 0, 0}).ranges, 0u);
}

TEST(JointDrift, FixedKeepsItsTurn) {
  const Vector3 axis = Vector3(1, 2, 2).normalized();
  EXPECT_NEAR(drift_at(FixedJoint{}, Vector3::Zero(), turned(-0.25, axis)).angle_max, 0.25, exact);
  EXPECT_NEAR(drift_at(FixedJoint{}, Vector3::Zero(), turned(2 * pi - 0.25, axis)).angle_max, 0.25, exact);
}

TEST(JointDrift, RodKeepsItsLengthAndRopeDoesNotStretch) {
  const auto distance = [](double lower, double upper) { return DistanceJoint{.distance = {.range = {lower, upper}}}; };
  EXPECT_NEAR(drift_at(distance(2, 2), {0, 1.5, 0}).max, 0.5, exact);
  EXPECT_NEAR(drift_at(distance(2, 2), {0, 0, -2.5}).max, 0.5, exact);
  EXPECT_EQ(drift_at(distance(2, 2), {0, 0, -2.5}).excess_max, 0);
  EXPECT_EQ(drift_at(distance(0, 2), {0, 0, -1.9}).excess_max, 0);
  EXPECT_NEAR(drift_at(distance(0, 2), {0, 0, -2.1}).excess_max, 0.1, exact);
  EXPECT_NEAR(drift_at(distance(1, 2), {0, 0.6, 0}).excess_max, 0.4, exact);
  EXPECT_EQ(drift_at(distance(0, 2), {0, 0, -2.1}).max, 0);
}

TEST(JointDrift, CrossKeepsItsAxesAtRightAngles) {
  const UniversalJoint cross = {.first = {.range = {-0.2, 0.2}}, .second = {.range = {-0.3, 0.3}}};
  // First about the first x axis, then about the second y axis, as the frames of a cross turn.
  const auto at = [&](double first, double second, double skew) {
    return drift_at(
        cross, Vector3::Zero(),
        turned(first, Vector3::UnitX()) * turned(skew, Vector3::UnitZ()) * turned(second, Vector3::UnitY()));
  };
  EXPECT_LT(at(0.15, -0.25, 0).angle_max, exact);
  EXPECT_EQ(at(0.15, -0.25, 0).angle_excess_max, 0);
  EXPECT_NEAR(at(0.5, -0.25, 0).angle_excess_max, 0.3, exact);
  EXPECT_NEAR(at(-0.15, 0.4, 0).angle_excess_max, 0.1, exact);
  EXPECT_NEAR(at(0, 0, 0.05).angle_max, 0.05, exact);
  EXPECT_EQ(at(0, 0, 0).angle_ranges, 1u);
}

TEST(JointDrift, ConeLimitsSwingAndTwist) {
  const ConeTwistJoint cone = {.swing_limit = 0.5, .twist = {.range = {-0.1, 0.3}}};
  const auto excess = [&](double swing, double about, double twist) {
    const Vector3 axis(0, std::cos(about), std::sin(about));
    return drift_at(cone, Vector3::Zero(), turned(swing, axis) * turned(twist, Vector3::UnitX())).angle_excess_max;
  };
  for (const double about : {0.0, 1.0, 4.0}) {
    EXPECT_LT(excess(0.49, about, 0.29), exact) << about;
    EXPECT_NEAR(excess(0.6, about, 0.2), 0.1, exact) << about;
    EXPECT_NEAR(excess(0.4, about, 0.45), 0.15, exact) << about;
    EXPECT_NEAR(excess(0.4, about, -0.3), 0.2, exact) << about;
  }
}

TEST(JointDrift, SixAxesEachAreLockedLimitedOrFree) {
  SixDofJoint six;
  six.offset[0].range = {1, 1};
  six.offset[1].range = {0, 0};
  six.offset[2].range = {-1, 1};
  six.turn[1].range = {-0.1, 0.1};
  six.turn[2].range = {0, 0};
  EXPECT_NEAR(drift_at(six, {1.03, 0.04, 0.5}).max, 0.05, exact);
  EXPECT_NEAR(drift_at(six, {1, 0, 1.5}).excess_max, 0.5, exact);
  EXPECT_NEAR(drift_at(six, {1, 0, 0}, turned(0.3, Vector3::UnitY())).angle_excess_max, 2 * std::sin(0.15) - 0.1,
              exact);
  EXPECT_NEAR(drift_at(six, {1, 0, 0}, turned(-0.3, Vector3::UnitZ())).angle_max, 2 * std::sin(0.15), exact);
  EXPECT_LT(drift_at(six, {1, 0, 0}, turned(2, Vector3::UnitX())).angle_max, exact);
}

TEST(JointDrift, AnglesOneAfterAnotherEachAreLockedLimitedOrFree) {
  SixDofJoint six;
  six.turn = {JointAxis{.range = {0, 0}}, JointAxis{}, JointAxis{.range = {-0.1, 0.3}}};
  for (const SixDofTurns turns : {SixDofTurns::AnglesXYZ, SixDofTurns::AnglesXZY}) {
    six.turns = turns;
    const auto drift = [&](double x, double z) {
      const Quaternion y = turned(1.2, Vector3::UnitY()), last = turned(z, Vector3::UnitZ());
      return drift_at(six, Vector3::Zero(),
                      turned(x, Vector3::UnitX()) * (turns == SixDofTurns::AnglesXYZ ? y * last : last * y));
    };
    EXPECT_LT(drift(0, 0.29).angle_excess_max, exact);
    EXPECT_NEAR(drift(0.05, 0.4).angle_max, 0.05, exact);
    EXPECT_NEAR(drift(0.05, 0.4).angle_excess_max, 0.1, exact);
    EXPECT_NEAR(drift(0, -0.3).angle_excess_max, 0.2, exact);
  }
}

TEST(JointDrift, WheelKeepsItsPlaceAndItsAxle) {
  const WheelJoint wheel = {.suspension = {.range = {-0.1, 0.1}, .spring = JointSpring{}}};
  EXPECT_NEAR(drift_at(wheel, {0.03, 0.04, 0.05}).max, 0.05, exact);
  EXPECT_EQ(drift_at(wheel, {0, 0, 0.05}).excess_max, 0);
  EXPECT_NEAR(drift_at(wheel, {0, 0, 0.25}).excess_max, 0.15, exact);
  EXPECT_LT(drift_at(wheel, {0, 0, 0}, turned(40, Vector3::UnitY())).angle_max, exact) << "it rolls";
  EXPECT_NEAR(drift_at(wheel, {0, 0, 0}, turned(0.1, Vector3::UnitX())).angle_max, 0.1, exact);
  EXPECT_NEAR(drift_at(wheel, {0, 0, 0}, turned(0.2, Vector3::UnitZ())).angle_max, 0.2, exact) << "locked steering";
  const WheelJoint steered = {.steering = {.range = {-0.5, 0.5}}};
  EXPECT_LT(drift_at(steered, {0, 0, 0}, turned(0.2, Vector3::UnitZ()) * turned(3, Vector3::UnitY())).angle_max, exact);
  EXPECT_NEAR(
      drift_at(steered, {0, 0, 0}, turned(-0.6, Vector3::UnitZ()) * turned(3, Vector3::UnitY())).angle_excess_max, 0.1,
      exact);
}

TEST(JointDrift, ReportsTheWorstOfAllAndTheirMeans) {
  std::vector<BodyState> states(4);
  states[1].pose.position = {0.03, 0, 0};
  states[2].pose.position = {0.03, 0.1, 0};
  states[3].pose.position = {0.03, 0.1, 0.02};
  const std::vector<PlacedJoint> joints = {
      {BallJoint{}, 0, 1, {}, {}}, {BallJoint{}, 2, 1, {}, {}}, {BallJoint{}, 2, 3, {}, {}}};
  const JointDriftReport report = measure_joint_drift(joints, states);
  EXPECT_NEAR(report.max, 0.1, exact);
  EXPECT_EQ(report.worst, 1u);
  EXPECT_NEAR(report.mean, 0.05, exact);
  EXPECT_NEAR(report.rms, std::sqrt((0.0009 + 0.01 + 0.0004) / 3), exact);
  EXPECT_EQ(measure_joint_drift({}, states).max, 0);
  expect_error([&] { measure_joint_drift(joints, std::span(states).first(3)); },
               {"joint 2", "body 3", "one of the 3 states"});
}

std::optional<double> value_of(const ErrorMeter& meter, const std::string& name) {
  for (const ErrorMeasure& error : meter.errors()) {
    if (error.name == name) return error.value;
  }
  return std::nullopt;
}

Scene two_joined() {
  Scene scene;
  scene.bodies = {{.def = {.type = BodyType::Static, .shape = Sphere{}}},
                  {.def = {.shape = Sphere{}, .position = {0, 0, -0.5}}}};
  SceneJoint joint;
  joint.first = 0;
  joint.second = 1;
  joint.def = {
      .kind = BallJoint{}, .frame_first = {.position = {0, 0, -0.25}}, .frame_second = {.position = {0, 0, 0.25}}};
  scene.joints = {joint};
  return scene;
}

std::vector<BodyState> moved(const Scene& scene, double gap) {
  std::vector<BodyState> states;
  for (const SceneBody& body : scene.bodies) states.push_back({.pose = {body.def.position, body.def.orientation}});
  states[1].pose.position.x() += gap;
  return states;
}

TEST(JointErrors, AreOfTheLastStateAndOfTheRun) {
  const Scene scene = two_joined();
  ErrorMeter meter(scene);
  meter.observe(1, moved(scene, 0.3));
  meter.observe(2, moved(scene, 0.1));
  EXPECT_NEAR(value_of(meter, "joint_gap_run_mean").value(), 0.2, exact);
  EXPECT_NEAR(value_of(meter, "joint_gap_run_max").value(), 0.3, exact);
  EXPECT_NEAR(value_of(meter, "joint_drift_max").value(), 0.1, exact);
  EXPECT_NEAR(value_of(meter, "joint_drift_rms").value(), 0.1, exact);
  EXPECT_FALSE(value_of(meter, "joint_angle_max")) << "a ball locks no angle";
  EXPECT_FALSE(value_of(meter, "joint_excess_max"));

  ErrorMeter of_end(scene, ErrorMeter::Follow::End);
  of_end.observe(2, moved(scene, 0.1));
  EXPECT_FALSE(value_of(of_end, "joint_gap_run_mean"));
  EXPECT_NEAR(value_of(of_end, "joint_drift_max").value(), 0.1, exact);
}

TEST(JointErrors, TellOnlyOfWhatJointsDo) {
  Scene scene = two_joined();
  scene.joints[0].def.kind = HingeJoint{.angle = {.range = {-1, 1}}};
  EXPECT_TRUE(value_of(ErrorMeter(scene), "joint_angle_max"));
  EXPECT_TRUE(value_of(ErrorMeter(scene), "joint_angle_excess_max"));
  EXPECT_FALSE(value_of(ErrorMeter(scene), "joint_excess_max"));
  scene.joints.clear();
  EXPECT_FALSE(value_of(ErrorMeter(scene), "joint_drift_max"));
}

TEST(JointErrors, OverlapOfBodiesThatMayNotTouchIsNone) {
  Scene scene = two_joined();
  EXPECT_EQ(value_of(ErrorMeter(scene), "penetration_max").value(), 0);
  scene.joints[0].def.collide = true;
  EXPECT_NEAR(value_of(ErrorMeter(scene), "penetration_max").value(), 0.5, exact);
  scene.bodies[1].def.filter.mask = 2;
  EXPECT_EQ(value_of(ErrorMeter(scene), "penetration_max").value(), 0);
  for (SceneBody& body : scene.bodies) body.def.filter.group = -7;
  EXPECT_FALSE(value_of(ErrorMeter(scene), "penetration_max")) << "nothing can overlap";
}

TEST(JointErrors, EnergyInSpringsAndMotorsIsNotAnError) {
  Scene scene = two_joined();
  ASSERT_TRUE(value_of(ErrorMeter(scene), "energy_drift"));
  scene.joints[0].def.kind = HingeJoint{.angle = {.motor = JointMotor{.speed = 0, .max_force = 1}}};
  EXPECT_TRUE(value_of(ErrorMeter(scene), "energy_drift")) << "friction loses it";
  scene.joints[0].def.kind = HingeJoint{.angle = {.motor = JointMotor{.speed = 1, .max_force = 1}}};
  EXPECT_FALSE(value_of(ErrorMeter(scene), "energy_drift"));
  scene.joints[0].def.kind = SliderJoint{.offset = {.spring = JointSpring{}}};
  EXPECT_FALSE(value_of(ErrorMeter(scene), "energy_drift"));
}

}  // namespace
}  // namespace atl::test::joint_drift_test
