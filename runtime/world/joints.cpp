#include "world/joints.h"

#include <atoll/error.h>
#include <solver/constraints/tendon.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "world/bodies.h"
#include "world/joint_definition.h"
#include "world/make_joint.h"
#include "world/tendons.h"

namespace atl {
namespace {

// Nearer than this the line between two points is a matter of rounding.
constexpr double least_distance = 1e-9;  // m

std::string text(BodyId id) {
  std::ostringstream out;
  out << "(index " << id.index << ", generation " << id.generation << ")";
  return out.str();
}

bool same_terms(const solver::Joint& a, const solver::Joint& b) {
  const auto end = a.term.begin() + a.terms;
  return a.terms == b.terms && std::equal(a.term.begin(), end, b.term.begin(), [](const auto& x, const auto& y) {
           return x.joint == y.joint && x.coordinate == y.coordinate;
         });
}

// True if the rows obey laws of the same kinds, perhaps with other numbers: then nothing that depends on the kinds of
// laws needs to be derived anew.
bool hold_the_same(const solver::Joint& a, const solver::Joint& b) {
  if (a.point != b.point || a.rows != b.rows || a.coordinate != b.coordinate || a.bounces != b.bounces) return false;
  if (!same_terms(a, b)) return false;
  for (std::size_t row = 0; row < a.rows; ++row) {
    const solver::Law& x = a.law[row];
    const solver::Law& y = b.law[row];
    if (x.locked() != y.locked() || x.limited() != y.limited()) return false;
    if (x.springs() != y.springs() || x.drives() != y.drives()) return false;
    if ((x.friction > 0) != (y.friction > 0)) return false;
  }
  return true;
}

// The row along a coordinate, or rows if there is none.
std::size_t row_along(const solver::Joint& joint, solver::Coordinate coordinate) {
  std::size_t row = 0;
  while (row < joint.rows && joint.coordinate[row] != coordinate) ++row;
  return row;
}

// Copies the state of a joint's coordinates (impulses, positions) to a joint with other rows.
void keep_state(const solver::Joint& from, solver::Joint& to) {
  if (from.point && to.point) to.point_impulse = from.point_impulse;
  to.tension = from.tension;
  for (std::size_t row = 0; row < to.rows; ++row) {
    const std::size_t old = row_along(from, to.coordinate[row]);
    if (old == from.rows) continue;
    to.impulse[row] = from.impulse[old];
    to.position[row] = from.position[old];
    to.limit[row] = from.limit[old];
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
  if (world.records.type[def.first.index] != BodyType::Dynamic &&
      world.records.type[def.second.index] != BodyType::Dynamic) {
    throw Error("JointDef: neither first " + text(def.first) + " nor second " + text(def.second) +
                " is dynamic; expected at least one that is");
  }
  // Joints know of masses that are the same in all directions only.
  for (const auto& [name, id] : {std::pair{"first", def.first}, std::pair{"second", def.second}}) {
    if (world.bodies.locks[id.index] == 0) continue;
    throw Error(std::string("JointDef.") + name + " is " + text(id) +
                ", which has motion locks; expected a body without, as joints don't know of them");
  }
}

JointId add_joint(Stores& world, const JointDef& definition) {
  const JointDef joined = with_bodies(world, definition);
  check_bodies(world, joined);
  const JointDef def = checked(joined);
  solver::Joint joint = make_joint(def, world.records.centre[def.first.index], world.records.centre[def.second.index]);
  bind_tendon(world, def.kind, joint, joint);
  if (std::holds_alternative<DistanceJoint>(def.kind) && !(frames_of(world, joint).offset.norm() > least_distance)) {
    throw Error("JointDef: the origins of the frames of a DistanceJoint coincide; expected two points");
  }
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
    ++world.joints.suspended[joint];
    world.joints.update_flags(joint);
    let_go(world, joint);
    let_go_of_tendons_over(world, joint);
  });
}

void resume_joints_of(Stores& world, std::uint32_t body) {
  world.joints.for_each_of(body, [&](std::uint32_t joint) {
    joint_changed(world, joint);
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

// kg or kg m^2: of two bodies along a row, if nothing else held them.
double mass_along(const solver::JointRow& row, const solver::Joint& joint, const solver::BodyTable& bodies) {
  const auto inverse_inertia = [&](std::uint32_t body) -> Matrix3 {
    const Matrix3 turn = bodies.orientation(body).toRotationMatrix();
    return turn * bodies.inverse_inertia[body] * turn.transpose();
  };
  return 1 / row.response(bodies.inverse_mass[joint.first] + bodies.inverse_mass[joint.second],
                          inverse_inertia(joint.first), inverse_inertia(joint.second));
}

// N or N m: a spring's, of a frequency with the mass along its row.
double spring_force(const solver::Law& law, double position, double speed, double mass) {
  if (law.spring_hertz == 0) return -law.stiffness * (position - law.rest) - law.damping * speed;
  const double omega = 2 * std::numbers::pi * law.spring_hertz;
  return -mass * omega * (omega * (position - law.rest) + 2 * law.damping_ratio * speed);
}

// N or N m, in the last substep of so many seconds, with a spring beside it; see JointState::motor.
double motor_force(const solver::Joint& joint, std::size_t row, double position, double speed, double spring,
                   double substep) {
  const solver::Law& law = joint.law[row];
  if (!law.drives() || substep == 0) return 0;
  const double most = law.motor_force;
  if (law.is_servo()) {
    const double wanted =
        law.servo_stiffness * (law.servo_target - position) + law.servo_damping * (law.motor_speed - speed);
    return std::clamp(wanted, -most, most);
  }
  const double way = law.motor_speed < 0 ? -1 : 1;
  if (law.motor_speed != 0 && joint.limit[row] * way > 0 && std::isfinite(most)) return way * most;
  const double all = joint.impulse[row] / substep - spring;
  // Friction holds back the motor; where both hold the coordinate still, it takes what it can.
  const double rubs = law.motor_speed != 0 ? -way * law.friction : std::clamp(all, -law.friction, law.friction);
  return std::clamp(all - rubs, -most, most);
}

}  // namespace

JointState joint_state(const Stores& world, std::uint32_t index) {
  const solver::Joint& joint = world.joints.joints[index];
  JointState state{.enabled = world.joints.enabled[index] != 0,
                   .broken = world.joints.broken[index] != 0,
                   .force = joint.force,
                   .torque = joint.torque};
  if (joint.is_tendon()) {
    const solver::TendonNow now = tendon_now(joint, world.joints.joints.data(), world.bodies);
    if (std::isfinite(now.length) && std::isfinite(now.rate)) {
      state.position[0] = now.length;
      state.speed[0] = now.rate;
      const double spring = spring_force(joint.law[0], now.length, now.rate, 0);
      state.motor[0] = motor_force(joint, 0, now.length, now.rate, spring, world.clock.last_substep);
    }
    return state;
  }
  const std::span<const solver::Coordinate> names = named_coordinates(world.joints.def[index]->kind);
  solver::Joint named = joint;
  named.rows = static_cast<std::uint8_t>(names.size());
  std::copy(names.begin(), names.end(), named.coordinate.begin());
  const solver::JointFrames frames = frames_of(world, named);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const solver::JointRow row = joint_row(named, i, frames);
    const std::size_t kept = row_along(joint, names[i]);
    const double position = kept == joint.rows ? row.value : continued(names[i], row.value, joint.position[kept]);
    const double speed = row.rate(world.bodies.velocity(joint.first), world.bodies.angular_velocity(joint.first),
                                  world.bodies.velocity(joint.second), world.bodies.angular_velocity(joint.second));
    // Skips joints of quarantined bodies, which may be anywhere.
    if (!std::isfinite(position) || !std::isfinite(speed)) continue;
    state.position[i] = position;
    state.speed[i] = speed;
    if (kept == joint.rows || !joint.law[kept].drives()) continue;
    const double spring = spring_force(joint.law[kept], position, speed, mass_along(row, joint, world.bodies));
    state.motor[i] = motor_force(joint, kept, position, speed, spring, world.clock.last_substep);
  }
  return state;
}

void set_joint(Stores& world, std::uint32_t index, const JointKind& kind) {
  JointDef def = *world.joints.def[index];
  if (kind.index() != def.kind.index()) {
    throw Error(std::string("World::set_joint: kind is ") + name_of(kind) + "; expected " + name_of(def.kind) +
                ", as the joint was made with");
  }
  check("World::set_joint: kind", kind);
  solver::Joint& joint = world.joints.joints[index];
  const solver::Joint before = joint;
  solver::Joint laws = make_joint(kind);
  bind_tendon(world, kind, before, laws);
  wake_joined_by(world, index);
  def.kind = kind;
  def = with_bodies(world, def);
  world.joints.def[index] = std::make_shared<const JointDef>(def);
  joint.first = def.first.index;
  joint.second = def.second.index;
  joint.term = laws.term;
  joint.terms = laws.terms;
  joint.point = laws.point;
  joint.rows = laws.rows;
  joint.coordinate = laws.coordinate;
  joint.law = laws.law;
  joint.ratio = laws.ratio;
  joint.bounces = laws.bounces;
  if (!hold_the_same(before, joint)) {
    forget_impulses(joint);
    joint.limit = {};
    find_positions(world, joint);
    keep_state(before, joint);
    world.changes.joints = true;
  }
  world.joints.update_flags(index);
}

void move_anchors(Stores& world, std::uint32_t body) {
  world.joints.for_each_of(body, [&](std::uint32_t index) {
    const JointDef& def = *world.joints.def[index];
    solver::Joint& joint = world.joints.joints[index];
    joint.anchor_first = def.frame_first.position - world.records.centre[def.first.index];
    joint.anchor_second = def.frame_second.position - world.records.centre[def.second.index];
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
  const std::size_t row = row_along(joint, names[coordinate]);
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
