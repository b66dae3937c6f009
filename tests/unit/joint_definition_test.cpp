// Every unusable definition of a joint is refused with the field and the value, and changes nothing; and what is locked
// is that alone.

#include <gtest/gtest.h>

#include <limits>
#include <string_view>
#include <vector>

#include "support/bodies.h"
#include "support/expect_error.h"
#include "world/make_joint.h"

namespace atl::test::joint_definition_test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct BadKind {
  JointKind kind;
  std::string_view field;
  std::string_view found;
  std::string_view expected;
};

JointAxis ranged(double lower, double upper) { return {.range = {lower, upper}}; }
JointAxis sprung(double hertz, double damping_ratio, double rest) {
  return {.spring = JointSpring{hertz, damping_ratio, rest}};
}
JointAxis driven(double speed, double max_force) { return {.motor = JointMotor{speed, max_force}}; }

JointAxis servo(const JointServo& servo) { return {.motor = JointMotor{0, 1, servo}}; }

const std::vector<BadKind>& bad_kinds() {
  static const std::vector<BadKind> kinds = {
      {BallJoint{-1.5}, "kind.friction", "-1.5", "not below 0"},
      {BallJoint{nan}, "kind.friction", "nan", "not below 0"},
      {BallJoint{unlimited}, "kind.friction", "inf", "finite"},
      {HingeJoint{ranged(2, 1)}, "kind.angle.range", "lower 2", "upper 1"},
      {HingeJoint{ranged(nan, 1)}, "kind.angle.range.lower", "nan", "a finite number, or -unlimited"},
      {HingeJoint{ranged(0, nan)}, "kind.angle.range.upper", "nan", "a finite number, or unlimited"},
      {HingeJoint{ranged(unlimited, unlimited)}, "kind.angle.range.lower", "inf", "-unlimited"},
      {HingeJoint{ranged(-unlimited, -unlimited)}, "kind.angle.range.upper", "-inf", "or unlimited"},
      {HingeJoint{sprung(0, 1, 0)}, "kind.angle.spring.hertz", "0", "above 0"},
      {HingeJoint{sprung(unlimited, 1, 0)}, "kind.angle.spring.hertz", "inf", "finite"},
      {HingeJoint{sprung(1, -1.5, 0)}, "kind.angle.spring.damping_ratio", "-1.5", "not below 0"},
      {HingeJoint{sprung(1, 1, nan)}, "kind.angle.spring.rest", "nan", "finite"},
      {HingeJoint{driven(unlimited, 1)}, "kind.angle.motor.speed", "inf", "finite"},
      {HingeJoint{driven(1, -1.5)}, "kind.angle.motor.max_force", "-1.5", "not below 0, or unlimited"},
      {HingeJoint{driven(1, nan)}, "kind.angle.motor.max_force", "nan", "not below 0, or unlimited"},
      {SliderJoint{ranged(0.5, -0.5)}, "kind.offset.range", "lower 0.5", "upper -0.5"},
      {DistanceJoint{ranged(-0.5, 1)}, "kind.distance.range.lower", "-0.5", "not below 0"},
      {DistanceJoint{ranged(0, 0)}, "kind.distance.range.upper", "0", "above 0"},
      {UniversalJoint{.first = driven(nan, 1)}, "kind.first.motor.speed", "nan", "finite"},
      {UniversalJoint{.second = ranged(1, 0)}, "kind.second.range", "lower 1", "upper 0"},
      {ConeTwistJoint{.swing_limit = 0}, "kind.swing_limit", "0", "(0, pi), in rad"},
      {ConeTwistJoint{.swing_limit = 3.25}, "kind.swing_limit", "3.25", "(0, pi), in rad"},
      {ConeTwistJoint{.swing_limit = nan}, "kind.swing_limit", "nan", "(0, pi), in rad"},
      {ConeTwistJoint{.swing_friction = -2}, "kind.swing_friction", "-2", "not below 0"},
      {ConeTwistJoint{.twist = ranged(-3.5, 0)}, "kind.twist.range.lower", "-3.5", "[-pi, pi], in rad"},
      {ConeTwistJoint{.twist = ranged(0, 3.5)}, "kind.twist.range.upper", "3.5", "[-pi, pi], in rad"},
      {SixDofJoint{.offset = {JointAxis{}, ranged(1, 0), JointAxis{}}}, "kind.offset[1].range", "lower 1", "upper 0"},
      {SixDofJoint{.turn = {JointAxis{}, JointAxis{}, ranged(0, 2.5)}}, "kind.turn[2].range.upper", "2.5", "[-2, 2]"},
      {SixDofJoint{.turn = {JointAxis{}, ranged(-2, 0), JointAxis{}}, .turns = SixDofTurns::AnglesXYZ},
       "kind.turn[1].range.lower", "-2", "[-pi/2, pi/2]"},
      {GearJoint{.ratio = 0}, "kind.ratio", "0", "other than 0"},
      {GearJoint{.ratio = nan}, "kind.ratio", "nan", "finite"},
      {WheelJoint{.suspension = sprung(-2, 1, 0)}, "kind.suspension.spring.hertz", "-2", "above 0"},
      {WheelJoint{.suspension = ranged(-1, 1)}, "kind.suspension", "no spring", "a spring or a motor"},
      {WheelJoint{.steering = ranged(1, 0)}, "kind.steering.range", "lower 1", "upper 0"},
      {WheelJoint{.spin = driven(0, -1)}, "kind.spin.motor.max_force", "-1", "not below 0"},
      {HingeJoint{{.range = {-1, 1, 1.5}}}, "kind.angle.range.restitution", "1.5", "[0, 1]"},
      {HingeJoint{{.range = {-1, 1, nan}}}, "kind.angle.range.restitution", "nan", "[0, 1]"},
      {SliderJoint{{.armature = -1}}, "kind.offset.armature", "-1", "not below 0"},
      {SliderJoint{servo({nan, 1, 1})}, "kind.offset.motor.servo.target", "nan", "finite"},
      {SliderJoint{servo({0, -1, 1})}, "kind.offset.motor.servo.stiffness", "-1", "not below 0"},
      {SliderJoint{servo({0, 1, unlimited})}, "kind.offset.motor.servo.damping", "inf", "not below 0"},
      {SliderJoint{servo({0, 0, 0})}, "kind.offset.motor.servo", "stiffness and damping are 0", "one of them above 0"},
  };
  return kinds;
}

struct Pair {
  World world;
  BodyId floor = world.add_body(ground());
  BodyId crate = world.add_body(box({0, 0, 5}));
  BodyId other = world.add_body(box({2, 0, 5}));

  void expect_refused(const JointDef& def, std::initializer_list<std::string_view> words) {
    const std::uint64_t hash = world.state_hash();
    expect_error([&] { world.add_joint(def); }, words);
    EXPECT_EQ(world.joint_count(), 0u) << *words.begin();
    EXPECT_EQ(world.state_hash(), hash) << *words.begin();
  }
};

TEST(JointDefinition, KindsThatMakeNoSenseAreRefused) {
  Pair pair;
  for (const BadKind& bad : bad_kinds()) {
    const std::string field = "JointDef." + std::string(bad.field);
    pair.expect_refused({.kind = bad.kind, .first = pair.crate, .second = pair.other},
                        {field, bad.found, "expected", bad.expected});
  }
}

TEST(JointDefinition, AChangeIsCheckedAsWell) {
  Pair pair;
  for (const BadKind& bad : bad_kinds()) {
    JointDef def{.first = pair.crate, .second = pair.other};
    def.kind = std::visit([](const auto& kind) { return JointKind(std::decay_t<decltype(kind)>{}); }, bad.kind);
    def.frame_first.position = {1, 0, 0};
    const JointId joint = pair.world.add_joint(def);
    const std::uint64_t hash = pair.world.state_hash();
    expect_error([&] { pair.world.set_joint(joint, bad.kind); },
                 {"World::set_joint: " + std::string(bad.field), bad.found, bad.expected});
    EXPECT_EQ(pair.world.state_hash(), hash) << bad.field;
    pair.world.remove_joint(joint);
  }
}

TEST(JointDefinition, AnchorsAndBreakingAreChecked) {
  Pair pair;
  const JointDef def{.first = pair.crate, .second = pair.other};
  const auto refused = [&](const auto& change, std::initializer_list<std::string_view> words) {
    JointDef bad = def;
    change(bad);
    pair.expect_refused(bad, words);
  };
  refused([](JointDef& d) { d.frame_first.position.y() = nan; }, {"JointDef.frame_first.position", "nan", "finite"});
  refused([](JointDef& d) { d.frame_second.position.z() = unlimited; }, {"JointDef.frame_second.position", "inf"});
  refused([](JointDef& d) { d.frame_first.orientation = Quaternion(0, 0, 0, 0); },
          {"JointDef.frame_first.orientation", "0", "quaternion"});
  refused([](JointDef& d) { d.frame_second.orientation.x() = nan; }, {"JointDef.frame_second.orientation", "nan"});
  refused([](JointDef& d) { d.break_force = 0; }, {"JointDef.break_force", "0", "above 0"});
  refused([](JointDef& d) { d.break_force = nan; }, {"JointDef.break_force", "nan"});
  refused([](JointDef& d) { d.break_torque = -1; }, {"JointDef.break_torque", "-1", "above 0, or unlimited"});
}

TEST(JointDefinition, BodiesAreCheckedFirst) {
  Pair pair;
  const BodyId gone = pair.world.add_body(box({9, 0, 5}));
  pair.world.remove_body(gone);
  const auto refused = [&](BodyId first, BodyId second, std::initializer_list<std::string_view> words) {
    pair.expect_refused({.kind = BallJoint{-1}, .first = first, .second = second}, words);
  };
  refused({}, pair.crate, {"JointDef.first", "4294967295", "no body has"});
  refused(pair.crate, {}, {"JointDef.second", "no body has"});
  refused(pair.crate, gone, {"JointDef.second", "index 3, generation 0", "has not been removed"});
  refused(pair.crate, pair.crate, {"JointDef.second", "index 1, generation 0", "another body"});
}

TEST(JointDefinition, ADistanceNeedsADirection) {
  Pair pair;
  JointDef def{.kind = DistanceJoint{ranged(0, 3)}, .first = pair.crate, .second = pair.other};
  def.frame_first.position = {2, 0, 0};
  pair.expect_refused(def, {"JointDef", "DistanceJoint", "coincide"});
  def.frame_first.position = {1, 0, 0};
  EXPECT_NO_THROW(pair.world.add_joint(def));
}

TEST(JointDefinition, EveryKindWithItsDefaultsIsUsable) {
  Pair pair;
  for (const JointKind& kind :
       {JointKind(BallJoint{}), JointKind(HingeJoint{}), JointKind(SliderJoint{}), JointKind(FixedJoint{}),
        JointKind(DistanceJoint{}), JointKind(UniversalJoint{}), JointKind(ConeTwistJoint{}), JointKind(SixDofJoint{}),
        JointKind(GearJoint{}), JointKind(WheelJoint{})}) {
    EXPECT_NO_THROW(pair.world.add_joint({.kind = kind, .first = pair.crate, .second = pair.other})) << kind.index();
  }
}

TEST(JointDefinition, WhatIsLockedHasNeitherSpringNorMotor) {
  JointAxis axis = sprung(1, 1, 0.5);
  axis.motor = JointMotor{1, unlimited};
  axis.range = {0.25, 0.25};
  const solver::Joint joint = make_joint(JointKind(HingeJoint{axis}));
  const solver::Law& law = joint.law[2];
  EXPECT_TRUE(law.locked());
  EXPECT_EQ(law.lower, 0.25);
  EXPECT_EQ(law.spring_hertz, 0);
  EXPECT_EQ(law.motor_force, 0);
}

}  // namespace
}  // namespace atl::test::joint_definition_test
