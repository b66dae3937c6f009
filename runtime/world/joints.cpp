#include "world/joints.h"

#include <atoll/error.h>
#include <jobs/assert.h>
#include <solver/constraints/tendon.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "world/bodies.h"
#include "world/make_joint.h"

namespace atl {
namespace {

// Nearer than this the line between two points is a matter of rounding.
constexpr double min_distance = 1e-9;  // m

std::string text(BodyId id) {
  std::ostringstream out;
  out << "(index " << id.index << ", generation " << id.generation << ")";
  return out.str();
}

bool same_coordinates(const solver::Joint& a, const solver::Joint& b) {
  const auto end = a.term.begin() + a.terms;
  return a.point == b.point && a.rows == b.rows && a.coordinate == b.coordinate && a.terms == b.terms &&
         std::equal(a.term.begin(), end, b.term.begin(),
                    [](const auto& x, const auto& y) { return x.joint == y.joint && x.coordinate == y.coordinate; });
}

// True if what chooses a method for joints that hang together sees no difference. It doesn't look at other numbers.
bool solved_alike(const solver::Joint& a, const solver::Joint& b) {
  if (!same_coordinates(a, b) || a.bounces != b.bounces || a.ratio != b.ratio) return false;
  if (a.anchor_first != b.anchor_first || a.anchor_second != b.anchor_second) return false;
  if (a.axes_first != b.axes_first || a.axes_second != b.axes_second) return false;
  return std::equal(a.law.begin(), a.law.begin() + a.rows, b.law.begin(), [](const auto& x, const auto& y) {
    return x.locked() == y.locked() && x.limited() == y.limited() && x.drives() == y.drives() &&
           x.is_servo() == y.is_servo() && (x.friction > 0) == (y.friction > 0) &&
           (x.armature > 0) == (y.armature > 0) && x.spring_hertz == y.spring_hertz &&
           x.damping_ratio == y.damping_ratio && x.stiffness == y.stiffness && x.damping == y.damping;
  });
}

// Copies the state of a joint's coordinates (impulses, positions) to a joint that may have other rows.
void keep_state(const solver::Joint& from, solver::Joint& to) {
  if (from.point && to.point) to.point_impulse = from.point_impulse;
  to.tension = from.tension;
  to.force = from.force;
  to.torque = from.torque;
  for (std::size_t row = 0; row < to.rows; ++row) {
    const std::size_t old = from.row_along(to.coordinate[row]);
    if (old == from.rows) continue;
    to.impulse[row] = from.impulse[old];
    to.position[row] = from.position[old];
    to.limit[row] = from.limit[old];
    to.motor_bound[row] = from.motor_bound[old];
    to.friction_bound[row] = from.friction_bound[old];
  }
}

// An angle is known but for full turns: it starts with the one nearest to its range.
void find_positions(const Stores& world, solver::Joint& joint) {
  if (joint.is_tendon()) {
    find_length(world, joint);
    return;
  }
  const solver::JointFrames frames = frames_of(world, joint);
  for (std::size_t row = 0; row < joint.rows; ++row) {
    const double value = joint_row(joint, row, frames).value;
    const double within = std::clamp(value, joint.law[row].lower, joint.law[row].upper);
    // Bodies so far apart are in quarantine, or will be in the next step.
    joint.position[row] = std::isfinite(value) ? continued(joint.coordinate[row], value, within) : 0;
  }
}

void forget_impulses(solver::Joint& joint) {
  joint.point_impulse.setZero();
  joint.tension.setZero();
  joint.impulse.fill(0);
  joint.motor_bound = joint.friction_bound = {};
}

// A joint that stops to act has nothing to start from, or to tell. Its bodies are where they are put: what they came to
// as they got lost may be no number.
void let_go(Stores& world, std::uint32_t joint) {
  solver::Joint& of = world.joints.joints[joint];
  forget_impulses(of);
  of.force.setZero();
  of.torque.setZero();
  of.limit = {};
  world.joints.limit_before[joint] = {};
  find_positions(world, of);
}

void let_go_of_tendons_over(Stores& world, std::uint32_t joint) {
  if (world.joints.joints[joint].is_tendon()) return;
  for (const std::uint32_t tendon : world.joints.tendons_over(joint)) let_go(world, tendon);
}

// Disables the pair of the joint's bodies in the broadphase, unless it is disabled already.
void keep_apart(Stores& world, std::uint32_t joint) {
  const solver::Joint& j = world.joints.joints[joint];
  if (world.joints.keep_apart(j.first, j.second)) world.broadphase.disable_pair(j.first, j.second);
}

void let_touch(Stores& world, std::uint32_t joint) {
  const solver::Joint& j = world.joints.joints[joint];
  if (!world.joints.let_touch(j.first, j.second)) return;
  const auto disabled = world.records.disabled_pairs.find(j.first);
  const bool stay_apart =
      disabled != world.records.disabled_pairs.end() &&
      std::find(disabled->second.begin(), disabled->second.end(), j.second) != disabled->second.end();
  if (!stay_apart) world.broadphase.enable_pair(j.first, j.second);
}

}  // namespace

void check_bodies(const Stores& world, const JointDef& def) {
  const char* expected = ", which no body has; expected the id of a body that has not been removed";
  if (!contains(world, def.first)) throw Error("JointDef.first is " + text(def.first) + expected);
  if (!contains(world, def.second)) throw Error("JointDef.second is " + text(def.second) + expected);
  if (def.first == def.second) {
    throw Error("JointDef.second is " + text(def.second) + ", as is first; expected another body");
  }
}

namespace {

solver::Joint make_joint(const Stores& world, const JointDef& def) {
  return make_joint(def, world.records.centre[def.first.index], world.records.centre[def.second.index]);
}

// A wheel weighs a tenth of its load or less. By its mass, as other springs count, a spring that turns a few times a
// second would not carry the chassis.
JointDef with_suspension(const Stores& world, JointDef def) {
  auto* wheel = std::get_if<WheelJoint>(&def.kind);
  const std::uint32_t chassis = def.first.index;
  if (wheel == nullptr || !wheel->suspension.spring || !world.records.dynamic[chassis]) return def;
  JointSpring& spring = *wheel->suspension.spring;
  if (spring.is_linear()) return def;
  const Vector3 along = def.frame_first.orientation * Vector3::UnitZ();
  const Vector3 moment = (def.frame_first.position - world.records.centre[chassis]).cross(along);
  const Matrix3& inverse_inertia = world.bodies.inverse_inertia[chassis];
  const double mass = 1 / (world.bodies.inverse_mass[chassis] + moment.dot(inverse_inertia * moment));
  const double omega = 2 * std::numbers::pi * spring.hertz;
  spring = {.rest = spring.rest, .stiffness = mass * omega * omega, .damping = 2 * mass * omega * spring.damping_ratio};
  check("JointDef.kind", def.kind);  // a stiffness may be beyond bounds where a frequency is not
  return def;
}

void check_direction(const Stores& world, const JointDef& def, const solver::Joint& joint) {
  if (std::holds_alternative<DistanceJoint>(def.kind) && !(frames_of(world, joint).offset.norm() > min_distance)) {
    throw Error("JointDef: the origins of the frames of a DistanceJoint coincide; expected two points");
  }
}

}  // namespace

JointId add_joint(Stores& world, const JointDef& definition) {
  const JointDef joined = with_bodies(world, definition);
  check_bodies(world, joined);
  const JointDef def = with_suspension(world, checked(joined));
  solver::Joint joint = make_joint(world, def);
  bind_tendon(world, def.kind, joint, joint);
  check_direction(world, def, joint);
  find_positions(world, joint);
  const std::uint32_t index = world.joints.add(def, joint);
  for (const BodyId body : {def.first, def.second}) {
    world.joints.suspended[index] += !joint.is_tendon() && world.quarantine.contains(body.index);
  }
  world.joints.update_flags(index);
  joint_changed(world, index);
  if (!def.collide) keep_apart(world, index);
  return {index, world.joints.generation[index]};
}

void remove_joint(Stores& world, std::uint32_t joint) {
  for (const std::uint32_t tendon : world.joints.tendons_over(joint)) remove_joint(world, tendon);
  joint_changed(world, joint);
  if (world.joints.enabled[joint] && !world.joints.def[joint]->collide) let_touch(world, joint);
  world.joints.remove(joint);
}

// In order, as their indices are used again.
void remove_joints_of(Stores& world, std::uint32_t body) {
  std::vector<std::uint32_t> of_body;
  world.joints.for_each_of(body, [&](std::uint32_t joint) { of_body.push_back(joint); });
  std::sort(of_body.begin(), of_body.end());
  for (const std::uint32_t joint : of_body) remove_joint(world, joint);
}

// Removes the body's joints for everyone else: the other bodies wake and are solved anew.
void suspend_joints_of(Stores& world, std::uint32_t body) {
  world.joints.for_each_of(body, [&](std::uint32_t joint) {
    joint_changed(world, joint);
    ATL_ASSERT(world.joints.suspended[joint] < 2, joint, body);  // once for each of its bodies
    ++world.joints.suspended[joint];
    world.joints.update_flags(joint);
    let_go(world, joint);
    let_go_of_tendons_over(world, joint);
  });
}

void resume_joints_of(Stores& world, std::uint32_t body) {
  world.joints.for_each_of(body, [&](std::uint32_t joint) {
    joint_changed(world, joint);
    ATL_ASSERT(world.joints.suspended[joint] > 0, joint, body);
    --world.joints.suspended[joint];
    world.joints.update_flags(joint);
    find_positions(world, world.joints.joints[joint]);
    for (const std::uint32_t tendon : world.joints.tendons_over(joint)) find_length(world, world.joints.joints[tendon]);
  });
}

solver::JointFrames frames_of(const Stores& world, const solver::Joint& joint) {
  return solver::joint_frames(joint, world.bodies);
}

namespace {

// The definition that a joint is to have after another, with the bits of what it says again.
JointDef checked_change(const Stores& world, const JointDef& before, const JointDef& definition) {
  if (definition.kind.index() != before.kind.index()) {
    throw Error(std::string("World::set_joint: kind is ") + name_of(definition.kind) + "; expected " +
                name_of(before.kind) + ", as the joint was made with");
  }
  JointDef def = checked(with_bodies(world, definition));
  if (!std::holds_alternative<TendonJoint>(def.kind) && (def.first != before.first || def.second != before.second)) {
    throw Error("World::set_joint: the bodies are " + text(def.first) + " and " + text(def.second) + "; expected " +
                text(before.first) + " and " + text(before.second) + ", as the joint was made with");
  }
  // Scaled to unit length again, an orientation may differ in its last bits.
  for (Pose JointDef::*frame : {&JointDef::frame_first, &JointDef::frame_second}) {
    const Quaternion& held = (before.*frame).orientation;
    if ((definition.*frame).orientation == held) (def.*frame).orientation = held;
  }
  return with_suspension(world, std::move(def));
}

}  // namespace

void set_joint(Stores& world, std::uint32_t index, const JointDef& definition) {
  const std::shared_ptr<const JointDef> before = world.joints.def[index];
  JointDef def = checked_change(world, *before, definition);
  JointDef renamed = *before;
  renamed.name = def.name;
  renamed.user_data = def.user_data;
  if (def == renamed) {
    world.joints.def[index] = std::make_shared<const JointDef>(std::move(renamed));
    return;
  }
  const solver::Joint was = world.joints.joints[index];
  solver::Joint joint = make_joint(world, def);
  bind_tendon(world, def.kind, was, joint);
  if (def.frame_first != before->frame_first || def.frame_second != before->frame_second) {
    check_direction(world, def, joint);
  }
  wake_joined_by(world, index);
  if (!same_coordinates(was, joint)) find_positions(world, joint);
  keep_state(was, joint);
  world.joints.joints[index] = joint;
  wake_joined_by(world, index);
  world.changes.joints |= !solved_alike(was, joint);
  if (world.joints.enabled[index] && def.collide != before->collide) {
    def.collide ? let_touch(world, index) : keep_apart(world, index);
  }
  world.joints.def[index] = std::make_shared<const JointDef>(std::move(def));
  world.joints.update_flags(index);
}

void drive(Stores& world, std::uint32_t index, std::size_t coordinate, const JointMotor& motor) {
  const JointKind& before = world.joints.def[index]->kind;
  if (named_axis(before, coordinate)->motor == motor) return;
  solver::Joint& joint = world.joints.joints[index];
  const std::size_t row = joint.row_along(named_coordinates(before)[coordinate]);
  auto def = std::make_shared<JointDef>(*world.joints.def[index]);
  named_axis(def->kind, coordinate)->motor = motor;
  world.joints.def[index] = std::move(def);
  if (row < joint.rows && joint.law[row].drives()) {
    joint.law[row].motor_speed = motor.speed;
    if (motor.servo) joint.law[row].servo_target = motor.servo->target;
  }
  wake_joined_by(world, index);
  world.joints.update_flags(index);
}

void move_anchors(Stores& world, std::uint32_t body) {
  world.joints.for_each_of(body, [&](std::uint32_t index) {
    const JointDef& def = *world.joints.def[index];
    solver::Joint& joint = world.joints.joints[index];
    joint.anchor_first = def.frame_first.position - world.records.centre[def.first.index];
    joint.anchor_second = def.frame_second.position - world.records.centre[def.second.index];
    if (!world.records.dynamic[def.first.index] && !world.records.dynamic[def.second.index]) let_go(world, index);
    joint_changed(world, index);
  });
}

void set_joint_enabled(Stores& world, std::uint32_t joint, bool enabled) {
  if (enabled) world.joints.broken[joint] = 0;
  if (enabled == (world.joints.enabled[joint] != 0)) return;
  joint_changed(world, joint);
  world.joints.enabled[joint] = enabled;
  world.joints.update_flags(joint);
  world.joints.joints[joint].force.setZero();
  world.joints.joints[joint].torque.setZero();
  if (!enabled) {
    release_joint(world, joint);
  } else if (!world.joints.def[joint]->collide) {
    keep_apart(world, joint);
  }
}

void count_turns_from(Stores& world, std::uint32_t index, double angle, std::size_t coordinate) {
  const JointKind& kind = world.joints.def[index]->kind;
  const std::span<const solver::Coordinate> names = named_coordinates(kind);
  if (coordinate >= names.size()) {
    throw Error(std::string("World::count_turns_from: coordinate is ") + std::to_string(coordinate) +
                "; expected one of the " + std::to_string(names.size()) + " that a " + name_of(kind) + " has");
  }
  solver::Joint& joint = world.joints.joints[index];
  const std::size_t row = joint.row_along(names[coordinate]);
  if (row == joint.rows || !counts_turns(names[coordinate])) return;
  const double value = joint_row(joint, row, frames_of(world, joint)).value;
  if (!std::isfinite(value)) return;  // of bodies in quarantine
  joint.position[row] = continued(names[coordinate], value, angle);
  for (const std::uint32_t tendon : world.joints.tendons_over(index)) find_length(world, world.joints.joints[tendon]);
  wake_joined_by(world, index);
}

void release_joint(Stores& world, std::uint32_t joint) {
  let_go_of_tendons_over(world, joint);
  forget_impulses(world.joints.joints[joint]);
  world.joints.joints[joint].limit = {};
  world.joints.limit_before[joint] = {};
  if (!world.joints.def[joint]->collide) let_touch(world, joint);
}

void joint_changed(Stores& world, std::uint32_t joint) {
  wake_joined_by(world, joint);
  world.changes.joints = true;
}

void wake_joined_by(Stores& world, std::uint32_t joint) {
  solver::for_each_term(world.joints.joints.data(), joint, [&](const solver::Joint& of) {
    world.sleeping.wake(of.first);
    world.sleeping.wake(of.second);
  });
  world.sleeping.wake(world.joints.joints[joint].first);
  world.sleeping.wake(world.joints.joints[joint].second);
}

void wake_joined(Stores& world, std::uint32_t body) {
  world.joints.for_each_of(body, [&](std::uint32_t joint) {
    if (world.joints.enabled[joint]) wake_joined_by(world, joint);
  });
}

}  // namespace atl
