#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "joining.h"
#include "schema.h"
#include "words.h"

namespace atl::scene {
namespace {

constexpr Range half_turn = between(-std::numbers::pi, std::numbers::pi);

JointRange read_range(const Reader& in, const Range& ends) {
  const auto [lower, upper] = in.numbers<2>("an array of two numbers, [lower, upper]", ends);
  if (lower > upper) {
    in.fail("[" + number_text(lower) + ", " + number_text(upper) + "]", "a lower end that is not above the upper one");
  }
  return {lower, upper};
}

JointSpring read_spring(const Reader& in) {
  in.only_keys({"hertz", "damping_ratio", "rest", "stiffness", "damping"});
  JointSpring spring;
  get(in, "rest", spring.rest);
  if (in.has("stiffness")) get(in, "stiffness", spring.stiffness.emplace(), at_least(0));
  if (in.has("damping")) get(in, "damping", spring.damping.emplace(), at_least(0));
  if (spring.is_linear()) {
    for (const char* key : {"hertz", "damping_ratio"}) {
      if (in.has(key)) in.fail(std::string("\"") + key + "\" with a stiffness or damping", "either of the two pairs");
    }
    return spring;
  }
  spring.hertz = in.at("hertz", "a number > 0, in Hz").number(above(0));
  get(in, "damping_ratio", spring.damping_ratio, at_least(0));
  return spring;
}

JointServo read_servo(const Reader& in) {
  in.only_keys({"target", "stiffness", "damping"});
  JointServo servo;
  get(in, "target", servo.target);
  get(in, "stiffness", servo.stiffness, at_least(0));
  get(in, "damping", servo.damping, at_least(0));
  if (servo.stiffness == 0 && servo.damping == 0) {
    in.fail("a servo without stiffness and damping", "one of them above 0");
  }
  return servo;
}

JointMotor read_motor(const Reader& in) {
  in.only_keys({"speed", "max_force", "servo"});
  JointMotor motor;
  get(in, "speed", motor.speed);
  const Reader force = in.at("max_force", "a number >= 0, in N, or N m where it turns");
  const bool without_limit = force.is<std::string>() && force.string() == "unlimited";
  motor.max_force = without_limit ? unlimited : force.number(at_least(0));
  if (const auto servo = in.find("servo")) motor.servo = read_servo(*servo);
  return motor;
}

JointAxis read_axis(const Reader& in, const Range& ends) {
  in.only_keys({"range", "lower", "upper", "restitution", "spring", "motor", "armature", "friction"});
  JointAxis axis;
  if (const auto range = in.find("range")) {
    for (const char* key : {"lower", "upper"}) {
      if (in.has(key)) in.fail_at(key, "it next to a range", "a range or a single end of one");
    }
    axis.range = read_range(*range, ends);
  }
  get(in, "lower", axis.range.lower, ends);
  get(in, "upper", axis.range.upper, ends);
  if (axis.range.lower > axis.range.upper) {
    in.fail_at("upper", number_text(axis.range.upper), "an upper end that is not below the lower one");
  }
  get(in, "restitution", axis.range.restitution, between(0, 1));
  get(in, "armature", axis.armature, at_least(0));
  get(in, "friction", axis.friction, at_least(0));
  if (const auto spring = in.find("spring")) axis.spring = read_spring(*spring);
  if (const auto motor = in.find("motor")) axis.motor = read_motor(*motor);
  return axis;
}

void get(const Reader& in, std::string_view key, JointAxis& target, const Range& ends = any_number) {
  if (const auto axis = in.find(key)) target = read_axis(*axis, ends);
}

void get(const Reader& in, std::string_view key, std::array<JointAxis, 3>& target, const Range& ends = any_number) {
  const auto axes = in.find(key);
  if (!axes) return;
  constexpr const char* what = "an array of three objects, of the x, y and z axis";
  if (axes->size(what) != 3) axes->expected(what);
  for (std::size_t i = 0; i < 3; ++i) target[i] = read_axis(axes->element(i), ends);
}

BallServo read_ball_servo(const Reader& in) {
  in.only_keys({"target", "angular_velocity", "stiffness", "damping", "max_torque"});
  BallServo servo;
  if (const auto target = in.find("target")) servo.target = read_orientation(*target);
  get(in, "angular_velocity", servo.angular_velocity);
  get(in, "stiffness", servo.stiffness, at_least(0));
  get(in, "damping", servo.damping, at_least(0));
  get(in, "max_torque", servo.max_torque, at_least(0));
  if (servo.stiffness == 0 && servo.damping == 0) {
    in.fail("a servo without stiffness and damping", "one of them above 0");
  }
  return servo;
}

JointKind read_ball(const Reader& in) {
  BallJoint joint;
  get(in, "friction", joint.friction, at_least(0));
  if (const auto servo = in.find("servo")) joint.servo = read_ball_servo(*servo);
  return joint;
}

JointKind read_hinge(const Reader& in) {
  HingeJoint joint;
  get(in, "angle", joint.angle);
  return joint;
}

JointKind read_slider(const Reader& in) {
  SliderJoint joint;
  get(in, "offset", joint.offset);
  return joint;
}

JointKind read_fixed(const Reader&) { return FixedJoint{}; }

JointKind read_distance(const Reader& in) {
  DistanceJoint joint;
  get(in, "distance", joint.distance, at_least(0));
  if (joint.distance.range.upper == 0) in.at("distance", "").fail("a largest distance of 0", "one above 0, or a ball");
  return joint;
}

JointKind read_universal(const Reader& in) {
  UniversalJoint joint;
  get(in, "angle_first", joint.first);
  get(in, "angle_second", joint.second);
  return joint;
}

JointKind read_cone_twist(const Reader& in) {
  ConeTwistJoint joint;
  get(in, "swing_limit", joint.swing_limit, above_up_to(0, std::nextafter(std::numbers::pi, 0)));
  get(in, "twist", joint.twist, half_turn);
  get(in, "swing_friction", joint.swing_friction, at_least(0));
  return joint;
}

JointKind read_six_dof(const Reader& in) {
  SixDofJoint joint;
  get(in, "offset", joint.offset);
  if (const auto turns = in.find("turns")) {
    joint.turns = static_cast<SixDofTurns>(turns->choice({"vector", "angles_xyz", "angles_xzy"}));
  }
  if (joint.turns == SixDofTurns::Vector) {
    get(in, "turn", joint.turn, between(-2, 2));
  } else {
    get(in, "turn", joint.turn);
  }
  return joint;
}

JointKind read_gear(const Reader& in) {
  GearJoint joint;
  if (const auto ratio = in.find("ratio")) {
    joint.ratio = ratio->number();
    if (joint.ratio == 0) ratio->expected("a number that is not 0");
  }
  get(in, "rack", joint.rack);
  return joint;
}

JointKind read_wheel(const Reader& in) {
  WheelJoint joint;
  get(in, "suspension", joint.suspension);
  get(in, "steering", joint.steering);
  get(in, "spin", joint.spin);
  return joint;
}

JointKind read_tendon(const Reader& in) {
  TendonJoint joint;
  get(in, "length", joint.length);
  return joint;
}

struct Kind {
  std::vector<std::string_view> keys;  ///< that joints of other kinds have not
  JointKind (*read)(const Reader&);
};

Kind read_kind(const Reader& in) {
  switch (in.choice({"ball", "hinge", "slider", "fixed", "distance", "universal", "cone_twist", "six_dof", "gear",
                     "wheel", "tendon"})) {
    case 0:
      return {{"friction", "servo"}, &read_ball};
    case 1:
      return {{"angle"}, &read_hinge};
    case 2:
      return {{"offset"}, &read_slider};
    case 3:
      return {{}, &read_fixed};
    case 4:
      return {{"distance", "at_second"}, &read_distance};
    case 5:
      return {{"angle_first", "angle_second", "across"}, &read_universal};
    case 6:
      return {{"swing_limit", "twist", "swing_friction", "across"}, &read_cone_twist};
    case 7:
      return {{"offset", "turn", "turns", "across"}, &read_six_dof};
    case 8:
      return {{"ratio", "rack", "axis_second"}, &read_gear};
    case 10:
      return {{"terms", "length"}, &read_tendon};
    default:
      return {{"suspension", "steering", "spin", "across"}, &read_wheel};
  }
}

Vector3 read_direction(const Reader& in) {
  Vector3 direction = read_vector(in);
  constexpr double min_length = 1e-6;
  if (!(direction.norm() > min_length) || !std::isfinite(direction.norm())) {
    in.fail("a vector of length " + number_text(direction.norm()), "a length above 0");
  }
  return direction;
}

Pose read_frame(const Reader& in) {
  in.only_keys({"position", "orientation"});
  Pose frame;
  get(in, "position", frame.position);
  if (const auto orientation = in.find("orientation")) frame.orientation = read_orientation(*orientation);
  return frame;
}

// The x axis along "axis" and the y axis towards "across"; of a wheel the z axis along "axis", up.
Quaternion read_axes(const Reader& in, bool wheel) {
  Vector3 axis = wheel ? Vector3::UnitZ() : Vector3::UnitX();
  if (const auto given = in.find("axis")) axis = read_direction(*given);
  const auto across = in.find("across");
  if (!across && !wheel) return frame_along(axis);
  const Vector3 y = across ? read_direction(*across) : Vector3::UnitY();
  constexpr double min_sine = 1e-3;
  if (!(axis.normalized().cross(y.normalized()).norm() > min_sine)) {
    in.fail_at("across", "a direction along the axis", "one at right angles to it");
  }
  // The cross product of y and z is x.
  return wheel ? frame_along(y.cross(axis), y) : frame_along(axis, y);
}

// Frames in the world, in which the bodies start, or in the bodies themselves.
void read_frames(const Reader& in, const Scene& scene, SceneJoint& joint) {
  const bool gear = std::holds_alternative<GearJoint>(joint.def.kind);
  const bool wheel = std::holds_alternative<WheelJoint>(joint.def.kind);
  if (in.has("frame_first") || in.has("frame_second")) {
    for (const char* key : {"at", "at_second", "axis", "axis_second", "across"}) {
      if (in.has(key)) in.fail_at(key, "it next to frames of the bodies", "one or the other");
    }
    if (const auto frame = in.find("frame_first")) joint.def.frame_first = read_frame(*frame);
    if (const auto frame = in.find("frame_second")) joint.def.frame_second = read_frame(*frame);
    return;
  }
  Pose first, second;
  if (!gear || in.has("at")) first.position = read_vector(in.at("at", "[x, y, z] in m, world axes, or frame_first"));
  second.position = first.position;
  get(in, "at_second", second.position);
  first.orientation = second.orientation = read_axes(in, wheel);
  if (const auto axis = in.find("axis_second")) second.orientation = frame_along(read_direction(*axis));
  joint.def.frame_first = seen_from(scene.bodies[joint.first].def, first);
  joint.def.frame_second = seen_from(scene.bodies[joint.second].def, second);
}

// The distance of the origins at the start: a rod of that length where the file says nothing else.
void read_length(const Reader& in, const Scene& scene, SceneJoint& joint) {
  auto* rod = std::get_if<DistanceJoint>(&joint.def.kind);
  if (rod == nullptr) return;
  const auto origin = [&](std::size_t body, const Pose& frame) -> Vector3 {
    const BodyDef& def = scene.bodies[body].def;
    return def.position + def.orientation.normalized() * frame.position;
  };
  const double length =
      (origin(joint.second, joint.def.frame_second) - origin(joint.first, joint.def.frame_first)).norm();
  constexpr double min_length = 1e-9;  // m, as add_joint has it
  if (!(length > min_length)) {
    in.fail_at(in.has("frame_first") || in.has("frame_second") ? "frame_second" : "at_second",
               "the ends of a distance joint in one place", "two places apart");
  }
  if (!in.has("distance")) rod->distance.range = {length, length};
}

}  // namespace

namespace {

TendonTerm read_term(const Reader& in) {
  in.only_keys({"joint", "coordinate", "polynomial"});
  TendonTerm term;
  int coordinate = 0;
  get(in, "coordinate", coordinate, 0, 5);
  term.coordinate = static_cast<std::uint32_t>(coordinate);
  const auto polynomial = in.find("polynomial");
  if (!polynomial) return term;
  constexpr const char* what = "an array of 2 to 5 numbers, of the powers of the coordinate from 0 on";
  const std::size_t count = polynomial->size(what);
  if (count < 2 || count > term.polynomial.size()) polynomial->expected(what);
  for (std::size_t i = 0; i < count; ++i) term.polynomial[i] = polynomial->element(i).number();
  if (std::all_of(term.polynomial.begin() + 1, term.polynomial.end(), [](double factor) { return factor == 0; })) {
    polynomial->fail("a constant", "a factor after the first that is not 0");
  }
  return term;
}

// It joins what its joints do.
void read_terms(const Reader& in, const Scene& scene, const Places& joints, SceneJoint& tendon) {
  const Reader terms = in.at("terms", "an array of terms");
  const std::size_t count = terms.size("an array of terms");
  if (count < 1 || count > TendonJoint::max_terms) {
    terms.fail(std::to_string(count) + " terms", "1 to " + std::to_string(TendonJoint::max_terms));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Reader joint = terms.element(i).at("joint", "the name of a joint above or its place among the joints");
    tendon.terms.push_back(joints.read(joint));
    if (std::holds_alternative<TendonJoint>(scene.joints[tendon.terms.back()].def.kind)) {
      joint.fail("a tendon", "a joint that is none");
    }
    std::get<TendonJoint>(tendon.def.kind).terms.push_back(read_term(terms.element(i)));
  }
  const SceneJoint& of = scene.joints[tendon.terms.front()];
  tendon.first = of.first;
  tendon.second = of.second;
  tendon.def.collide = true;
}

void read_bodies(const Reader& in, const Places& places, SceneJoint& joint) {
  constexpr const char* body = "the name of a body or its place among the bodies";
  joint.first = places.read(in.at("first", body));
  joint.second = places.read(in.at("second", body));
  if (joint.first == joint.second) in.fail_at("second", "the first body again", "another one");
}

}  // namespace

SceneJoint read_joint(const Reader& in, const Scene& scene, const Places& bodies, const Places& joints) {
  // The kind first: it says which keys there may be.
  in.members();
  const Kind kind = read_kind(in.at("kind", "ball, hinge, slider or another kind of joint"));
  const bool tendon = kind.read == &read_tendon;
  std::vector<std::string_view> keys = {"name", "kind"};
  if (!tendon) keys.insert(keys.end(), {"first", "second", "collide"});
  keys.insert(keys.end(), {"break_force", "break_torque", "user_data"});
  if (!tendon) keys.insert(keys.end(), {"at", "axis", "frame_first", "frame_second"});
  keys.insert(keys.end(), kind.keys.begin(), kind.keys.end());
  in.only_keys(keys);

  SceneJoint joint;
  read_name(in, joint.name);
  if (!tendon) read_bodies(in, bodies, joint);
  joint.def.kind = kind.read(in);
  if (tendon) {
    read_terms(in, scene, joints, joint);
  } else {
    read_frames(in, scene, joint);
    read_length(in, scene, joint);
    get(in, "collide", joint.def.collide);
  }
  get(in, "break_force", joint.def.break_force, above(0));
  get(in, "break_torque", joint.def.break_torque, above(0));
  get(in, "user_data", joint.def.user_data);
  return joint;
}

void Places::add(const std::string& name) {
  if (!name.empty()) names_.emplace(name, count_);
  ++count_;
}

std::size_t Places::read(const Reader& in) const {
  const std::string what = what_;
  if (count_ == 0) in.fail("no " + what + " yet", "one that is ahead of it in the file");
  if (!in.is<std::string>()) {
    return static_cast<std::size_t>(in.integer(0, static_cast<int>(count_) - 1));
  }
  if (const auto found = names_.find(in.string()); found != names_.end()) return found->second;
  constexpr std::size_t max_suggested_names = 1000;  // names that are looked through for one that is near
  std::vector<std::string_view> names;
  for (const auto& [name, place] : names_) {
    if (names.size() < max_suggested_names) names.push_back(name);
  }
  in.expected("the name of a " + what + suggestion(in.string(), names));
}

}  // namespace atl::scene
