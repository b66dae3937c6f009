// The one place that says what each kind of joint is.

#include "world/make_joint.h"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <type_traits>

namespace atl {
namespace {

using solver::Coordinate;
using solver::Law;

Law law_of(const JointAxis& axis) {
  Law law{.lower = axis.range.lower, .upper = axis.range.upper};
  if (law.locked()) return law;
  law.restitution = law.limited() ? axis.range.restitution : 0;
  law.armature = axis.armature;
  law.friction = axis.friction;
  if (axis.spring) {
    if (axis.spring->is_linear()) {
      law.stiffness = axis.spring->stiffness.value_or(0);
      law.damping = axis.spring->damping.value_or(0);
    } else {
      law.spring_hertz = axis.spring->hertz;
      law.damping_ratio = axis.spring->damping_ratio;
    }
    law.rest = axis.spring->rest;
  }
  if (axis.motor && axis.motor->max_force.value_or(0) > 0) {
    law.motor_speed = axis.motor->speed;
    law.motor_force = *axis.motor->max_force;
    if (const auto& servo = axis.motor->servo) {
      law.servo_target = servo->target;
      law.servo_stiffness = servo->stiffness;
      law.servo_damping = servo->damping;
    }
  }
  return law;
}

constexpr std::array rotations = {Coordinate::RotationX, Coordinate::RotationY, Coordinate::RotationZ};

// By SixDofTurns.
constexpr std::array<std::array<Coordinate, 6>, 3> six_names = {
    {{Coordinate::OffsetX, Coordinate::OffsetY, Coordinate::OffsetZ, Coordinate::TurnX, Coordinate::TurnY,
      Coordinate::TurnZ},
     {Coordinate::OffsetX, Coordinate::OffsetY, Coordinate::OffsetZ, Coordinate::AngleXOfZ, Coordinate::BetweenY,
      Coordinate::AngleSecondZ},
     {Coordinate::OffsetX, Coordinate::OffsetY, Coordinate::OffsetZ, Coordinate::AngleX, Coordinate::AngleSecondY,
      Coordinate::BetweenZ}}};

constexpr const std::array<Coordinate, 6>& names_of(const SixDofJoint& six) {
  return six_names[static_cast<std::size_t>(six.turns)];
}

bool holds_at_zero(const JointAxis& axis) { return axis.range.lower == 0 && axis.range.upper == 0; }

// Adds the rows of a kind.
struct Rows {
  solver::Joint& joint;

  void add(Coordinate coordinate, const Law& law) const {
    if (!law.acts()) return;
    joint.coordinate[joint.rows] = coordinate;
    joint.law[joint.rows] = law;
    joint.bounces |= law.restitution > 0;
    ++joint.rows;
  }
  void add(Coordinate coordinate, const JointAxis& axis) const { add(coordinate, law_of(axis)); }
  void lock(std::initializer_list<Coordinate> coordinates) const {
    for (const Coordinate coordinate : coordinates) add(coordinate, Law{.lower = 0, .upper = 0});
  }

  void operator()(const BallJoint& ball) const {
    joint.point = true;
    for (const Coordinate spin : {Coordinate::SpinX, Coordinate::SpinY, Coordinate::SpinZ}) {
      if (!ball.servo) add(spin, Law{.motor_force = ball.friction});
    }
    for (int axis = 0; axis < 3 && ball.servo; ++axis) {
      add(rotations[static_cast<std::size_t>(axis)], Law{.motor_speed = ball.servo->angular_velocity[axis],
                                                         .motor_force = ball.servo->max_torque,
                                                         .servo_stiffness = ball.servo->stiffness,
                                                         .servo_damping = ball.servo->damping,
                                                         .friction = ball.friction});
    }
  }

  void operator()(const HingeJoint& hinge) const {
    joint.point = true;
    lock({Coordinate::SwingAlongY, Coordinate::SwingAlongZ});
    add(Coordinate::Twist, hinge.angle);
  }

  void operator()(const SliderJoint& slider) const {
    lock({Coordinate::OffsetY, Coordinate::OffsetZ, Coordinate::TurnX, Coordinate::TurnY, Coordinate::TurnZ});
    add(Coordinate::OffsetX, slider.offset);
  }

  void operator()(const FixedJoint&) const {
    joint.point = true;
    lock({Coordinate::TurnX, Coordinate::TurnY, Coordinate::TurnZ});
  }

  void operator()(const DistanceJoint& rod) const {
    Law law = law_of(rod.distance);
    // No distance is less: what a rope holds passes through its anchor.
    if (law.lower == 0) law.lower = -Law::unlimited;
    add(Coordinate::Distance, law);
  }

  void operator()(const UniversalJoint& cross) const {
    joint.point = true;
    lock({Coordinate::SkewXY});
    add(Coordinate::AngleX, cross.first);
    add(Coordinate::AngleSecondY, cross.second);
  }

  void operator()(const ConeTwistJoint& cone) const {
    joint.point = true;
    add(Coordinate::Swing, Law{.upper = cone.swing_limit, .motor_force = cone.swing_friction});
    add(Coordinate::Orbit, Law{.motor_force = cone.swing_friction});
    add(Coordinate::Twist, cone.twist);
  }

  void operator()(const SixDofJoint& six) const {
    joint.point = std::all_of(six.offset.begin(), six.offset.end(), holds_at_zero);
    if (!joint.point) {
      for (std::size_t axis = 0; axis < 3; ++axis) add(names_of(six)[axis], six.offset[axis]);
    }
    for (std::size_t axis = 0; axis < 3; ++axis) add(names_of(six)[3 + axis], six.turn[axis]);
  }

  void operator()(const GearJoint& gear) const {
    joint.ratio = gear.ratio;
    lock({gear.rack ? Coordinate::Rack : Coordinate::Gear});
  }

  void operator()(const WheelJoint& wheel) const {
    lock({Coordinate::OffsetX, Coordinate::OffsetY, Coordinate::SkewZY});
    add(Coordinate::OffsetZ, wheel.suspension);
    add(Coordinate::Steer, wheel.steering);
    add(Coordinate::Roll, wheel.spin);
  }

  // The joints in the world tell which coordinates its terms are of: see bind_tendon().
  void operator()(const TendonJoint& tendon) const {
    add(Coordinate::Length, tendon.length);
    for (const TendonTerm& term : tendon.terms) {
      joint.term[joint.terms++] = {.joint = term.joint.index, .polynomial = term.polynomial};
    }
  }
};

}  // namespace

solver::Joint make_joint(const JointKind& kind) {
  solver::Joint joint;
  std::visit(Rows{joint}, kind);
  return joint;
}

solver::Joint make_joint(const JointDef& def, const Vector3& centre_first, const Vector3& centre_second) {
  solver::Joint joint = make_joint(def.kind);
  joint.first = def.first.index;
  joint.second = def.second.index;
  joint.anchor_first = def.frame_first.position - centre_first;
  joint.anchor_second = def.frame_second.position - centre_second;
  joint.axes_first = def.frame_first.orientation;
  joint.axes_second = def.frame_second.orientation;
  const auto* ball = std::get_if<BallJoint>(&def.kind);
  if (ball != nullptr && ball->servo) joint.axes_first = def.frame_first.orientation * ball->servo->target;
  return joint;
}

std::span<const solver::Coordinate> named_coordinates(const JointKind& kind) {
  using enum Coordinate;
  static constexpr Coordinate hinge[] = {Twist}, slider[] = {OffsetX}, distance[] = {Distance}, tendon[] = {Length};
  static constexpr Coordinate cross[] = {AngleX, AngleSecondY}, cone[] = {Swing, Twist};
  static constexpr Coordinate gear[] = {Gear}, rack[] = {Rack}, wheel[] = {OffsetZ, Steer, Roll};
  if (const auto* six = std::get_if<SixDofJoint>(&kind)) return names_of(*six);
  if (const auto* of = std::get_if<GearJoint>(&kind); of != nullptr && of->rack) return rack;
  // Ball and fixed joints have none.
  static constexpr std::array<std::span<const Coordinate>, std::variant_size_v<JointKind>> names = {
      {{}, hinge, slider, {}, distance, cross, cone, {}, gear, wheel, tendon}};
  return names[kind.index()];
}

namespace {

// `Kind` is JointKind, const or not.
template <typename Kind>
auto find_axis(Kind& kind, std::size_t coordinate) {
  using Axis = std::conditional_t<std::is_const_v<Kind>, const JointAxis, JointAxis>;
  const auto pick = [coordinate](std::initializer_list<Axis*> axes) {
    return coordinate < axes.size() ? *(axes.begin() + coordinate) : nullptr;
  };
  if (auto* hinge = std::get_if<HingeJoint>(&kind)) return pick({&hinge->angle});
  if (auto* slider = std::get_if<SliderJoint>(&kind)) return pick({&slider->offset});
  if (auto* rod = std::get_if<DistanceJoint>(&kind)) return pick({&rod->distance});
  if (auto* tendon = std::get_if<TendonJoint>(&kind)) return pick({&tendon->length});
  if (auto* cross = std::get_if<UniversalJoint>(&kind)) return pick({&cross->first, &cross->second});
  if (auto* cone = std::get_if<ConeTwistJoint>(&kind)) return pick({nullptr, &cone->twist});
  if (auto* wheel = std::get_if<WheelJoint>(&kind)) return pick({&wheel->suspension, &wheel->steering, &wheel->spin});
  if (auto* six = std::get_if<SixDofJoint>(&kind)) {
    auto& [offset, turn, turns] = *six;
    return pick({&offset[0], &offset[1], &offset[2], &turn[0], &turn[1], &turn[2]});
  }
  return static_cast<Axis*>(nullptr);
}

}  // namespace

JointAxis* named_axis(JointKind& kind, std::size_t coordinate) { return find_axis(kind, coordinate); }
const JointAxis* named_axis(const JointKind& kind, std::size_t coordinate) { return find_axis(kind, coordinate); }

}  // namespace atl
