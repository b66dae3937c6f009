#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include "world/body_definition.h"
#include "world/joints.h"
#include "world/refuse.h"

namespace atl {
namespace {

void check_above_zero_or_unlimited(std::string_view field, double value) {
  if (!(value > 0)) refuse(field, value, "a number above 0, or unlimited");
  if (value != unlimited) check_positive(field, value, loads);
}

// Within which the ends of a range make sense, where there are any.
struct Domain {
  double lower = -unlimited;
  double upper = unlimited;
  const char* name = "";
};

constexpr Domain any = {};
constexpr Domain not_negative = {0, unlimited, "a number not below 0, as distances are"};
constexpr Domain half_turn = {-std::numbers::pi, std::numbers::pi, "an angle in [-pi, pi], in rad"};
constexpr Domain quarter_turn = {-std::numbers::pi / 2, std::numbers::pi / 2, "an angle in [-pi/2, pi/2], in rad"};
constexpr Domain twice_a_sine = {-2, 2, "a number in [-2, 2], twice the sine of half the angle"};

void check_end(std::string_view field, double value, const Domain& domain) {
  if (std::isfinite(value)) check_number(field, value);
  if (std::isfinite(value) && (value < domain.lower || value > domain.upper)) refuse(field, value, domain.name);
}

void check_range(const std::string& field, const JointRange& range, const Domain& domain) {
  if (std::isnan(range.lower) || range.lower == unlimited) {
    refuse(field + ".lower", range.lower, "a finite number, or -unlimited");
  }
  if (std::isnan(range.upper) || range.upper == -unlimited) {
    refuse(field + ".upper", range.upper, "a finite number, or unlimited");
  }
  if (range.lower > range.upper) {
    std::ostringstream message;
    message << field << ": lower " << range.lower << " is above upper " << range.upper << "; expected it not to be";
    throw Error(message.str());
  }
  check_end(field + ".lower", range.lower, domain);
  check_end(field + ".upper", range.upper, domain);
  if (!(range.restitution >= 0 && range.restitution <= 1)) {
    refuse(field + ".restitution", range.restitution, "a number in [0, 1]");
  }
}

void check_servo(const std::string& field, const JointServo& servo) {
  check_number(field + ".target", servo.target);
  check_not_negative(field + ".stiffness", servo.stiffness, loads);
  check_not_negative(field + ".damping", servo.damping, loads);
  if (servo.stiffness == 0 && servo.damping == 0) {
    throw Error(field + ": stiffness and damping are 0; expected one of them above 0");
  }
}

void check_axis(const std::string& field, const JointAxis& axis, const Domain& domain = any) {
  check_range(field + ".range", axis.range, domain);
  if (axis.spring) {
    check_positive(field + ".spring.hertz", axis.spring->hertz);
    check_not_negative(field + ".spring.damping_ratio", axis.spring->damping_ratio);
    check_number(field + ".spring.rest", axis.spring->rest);
    if (axis.spring->stiffness) check_not_negative(field + ".spring.stiffness", *axis.spring->stiffness, loads);
    if (axis.spring->damping) check_not_negative(field + ".spring.damping", *axis.spring->damping, loads);
  }
  if (axis.motor) {
    check_finite(field + ".motor.speed", axis.motor->speed);
    if (!axis.motor->max_force) {
      throw Error(field + ".motor.max_force is not given; expected the most (N or N m) that it may push, or unlimited");
    }
    if (!(*axis.motor->max_force >= 0)) {
      refuse(field + ".motor.max_force", *axis.motor->max_force, "a number not below 0, or unlimited");
    }
    if (axis.motor->servo) check_servo(field + ".motor.servo", *axis.motor->servo);
  }
  check_not_negative(field + ".armature", axis.armature, loads);
  check_not_negative(field + ".friction", axis.friction, loads);
}

struct KindCheck {
  std::string what;

  void operator()(const BallJoint& ball) const {
    check_not_negative(what + ".friction", ball.friction, loads);
    if (!ball.servo) return;
    const std::string servo = what + ".servo";
    checked_orientation((servo + ".target").c_str(), ball.servo->target);
    check_number(servo + ".angular_velocity", ball.servo->angular_velocity);
    check_servo(servo, {.stiffness = ball.servo->stiffness, .damping = ball.servo->damping});
    if (!(ball.servo->max_torque >= 0)) {
      refuse(servo + ".max_torque", ball.servo->max_torque, "a number not below 0, or unlimited");
    }
  }
  void operator()(const HingeJoint& hinge) const { check_axis(what + ".angle", hinge.angle); }
  void operator()(const SliderJoint& slider) const { check_axis(what + ".offset", slider.offset); }
  void operator()(const FixedJoint&) const {}

  void operator()(const DistanceJoint& rod) const {
    check_axis(what + ".distance", rod.distance, not_negative);
    const JointRange& range = rod.distance.range;
    if (!(range.upper > 0)) refuse(what + ".distance.range.upper", range.upper, "a number above 0");
  }

  void operator()(const UniversalJoint& cross) const {
    check_axis(what + ".first", cross.first);
    check_axis(what + ".second", cross.second);
  }

  void operator()(const ConeTwistJoint& cone) const {
    if (!(cone.swing_limit > 0 && (cone.swing_limit < std::numbers::pi || cone.swing_limit == unlimited))) {
      refuse(what + ".swing_limit", cone.swing_limit, "an angle in (0, pi), in rad, or unlimited");
    }
    check_axis(what + ".twist", cone.twist, half_turn);
    check_not_negative(what + ".swing_friction", cone.swing_friction, loads);
  }

  void operator()(const SixDofJoint& six) const {
    if (six.turns > SixDofTurns::AnglesXZY) {
      refuse(what + ".turns", static_cast<int>(six.turns), "a value of SixDofTurns");
    }
    const std::size_t middle = six.turns == SixDofTurns::AnglesXYZ ? 1 : 2;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string index = "[" + std::to_string(i) + "]";
      check_axis(what + ".offset" + index, six.offset[i]);
      const Domain& angles = i == middle ? quarter_turn : any;
      check_axis(what + ".turn" + index, six.turn[i], six.turns == SixDofTurns::Vector ? twice_a_sine : angles);
    }
  }

  void operator()(const GearJoint& gear) const {
    if (!std::isfinite(gear.ratio) || gear.ratio == 0) {
      refuse(what + ".ratio", gear.ratio, "a finite number other than 0");
    }
    check_positive(what + ".ratio", std::abs(gear.ratio));
  }

  void operator()(const WheelJoint& wheel) const {
    check_axis(what + ".suspension", wheel.suspension);
    const JointAxis& suspension = wheel.suspension;
    const bool ends = suspension.range.lower > -unlimited || suspension.range.upper < unlimited;
    if (ends && suspension.range.lower < suspension.range.upper && !suspension.spring && !suspension.motor) {
      throw Error(what +
                  ".suspension has a range, but no spring: it replaces all of the default one; expected a spring "
                  "or a motor with the range, or equal ends");
    }
    check_axis(what + ".steering", wheel.steering);
    check_axis(what + ".spin", wheel.spin);
  }

  void operator()(const TendonJoint& tendon) const {
    if (tendon.terms.empty() || tendon.terms.size() > TendonJoint::max_terms) {
      throw Error(what + ".terms: there are " + std::to_string(tendon.terms.size()) + "; expected 1 to " +
                  std::to_string(TendonJoint::max_terms));
    }
    for (std::size_t i = 0; i < tendon.terms.size(); ++i) {
      const std::string field = what + ".terms[" + std::to_string(i) + "].polynomial";
      const auto& factors = tendon.terms[i].polynomial;
      for (const double factor : factors) check_number(field, factor);
      if (std::all_of(factors.begin() + 1, factors.end(), [](double factor) { return factor == 0; })) {
        throw Error(field + ": all factors after the first are 0; expected one that is not");
      }
    }
    check_axis(what + ".length", tendon.length);
  }
};

constexpr std::array<const char*, std::variant_size_v<JointKind>> kind_names = {
    "BallJoint",      "HingeJoint",  "SliderJoint", "FixedJoint", "DistanceJoint", "UniversalJoint",
    "ConeTwistJoint", "SixDofJoint", "GearJoint",   "WheelJoint", "TendonJoint"};

}  // namespace

void check(const char* what, const JointKind& kind) { std::visit(KindCheck{what}, kind); }

const char* name_of(const JointKind& kind) { return kind_names[kind.index()]; }

JointDef checked(const JointDef& def) {
  check("JointDef.kind", def.kind);
  check_number("JointDef.frame_first.position", def.frame_first.position);
  check_number("JointDef.frame_second.position", def.frame_second.position);
  check_above_zero_or_unlimited("JointDef.break_force", def.break_force);
  check_above_zero_or_unlimited("JointDef.break_torque", def.break_torque);
  check_name("JointDef.name", def.name);
  JointDef result = def;
  if (auto* ball = std::get_if<BallJoint>(&result.kind); ball != nullptr && ball->servo) {
    ball->servo->target = checked_orientation("JointDef.kind.servo.target", ball->servo->target);
  }
  result.frame_first.orientation = checked_orientation("JointDef.frame_first.orientation", def.frame_first.orientation);
  result.frame_second.orientation =
      checked_orientation("JointDef.frame_second.orientation", def.frame_second.orientation);
  return result;
}

}  // namespace atl
