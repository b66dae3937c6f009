// Joints coming, going and being changed from outside.

#include <atoll/error.h>

#include <algorithm>
#include <sstream>

#include "world/joint_definition.h"
#include "world/make_joint.h"
#include "world/world_impl.h"

namespace atl {
namespace {

// Nearer than this the line between two points is a matter of rounding.
constexpr double least_distance = 1e-9;  // m

std::string text(BodyId id) {
  std::ostringstream out;
  out << "(index " << id.index << ", generation " << id.generation << ")";
  return out.str();
}

// Whether rows obey other laws of the same kinds: those who asked what a joint holds needn't ask again.
bool hold_the_same(const solver::Joint& a, const solver::Joint& b) {
  if (a.point != b.point || a.rows != b.rows || a.coordinate != b.coordinate) return false;
  for (std::size_t row = 0; row < a.rows; ++row) {
    const solver::Law& x = a.law[row];
    const solver::Law& y = b.law[row];
    if (x.locked() != y.locked() || x.limited() != y.limited()) return false;
    if (x.springs() != y.springs() || x.drives() != y.drives()) return false;
  }
  return true;
}

// The row along a coordinate, or rows if there is none.
std::size_t row_along(const solver::Joint& joint, solver::Coordinate coordinate) {
  std::size_t row = 0;
  while (row < joint.rows && joint.coordinate[row] != coordinate) ++row;
  return row;
}

// What a joint knows of its coordinates goes over to one with other rows.
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
void find_positions(solver::Joint& joint, const solver::JointFrames& frames) {
  for (std::size_t row = 0; row < joint.rows; ++row) {
    const double value = joint_row(joint, row, frames).value;
    const double within = std::clamp(value, joint.law[row].lower, joint.law[row].upper);
    joint.position[row] = continued(joint.coordinate[row], value, within);
  }
}

void forget_impulses(solver::Joint& joint) {
  joint.point_impulse.setZero();
  joint.tension.setZero();
  joint.impulse.fill(0);
  joint.motor_bound = {};
}

}  // namespace

void World::Impl::check_bodies(const JointDef& def) const {
  const auto is_there = [this](BodyId id) {
    return id.index < bodies.size() && records.alive[id.index] && records.generation[id.index] == id.generation;
  };
  const char* expected = ", which no body has; expected the id of a body that has not been removed";
  if (!is_there(def.first)) throw Error("JointDef.first is " + text(def.first) + expected);
  if (!is_there(def.second)) throw Error("JointDef.second is " + text(def.second) + expected);
  if (def.first == def.second) {
    throw Error("JointDef.second is " + text(def.second) + ", as is first; expected another body");
  }
  if (records.type[def.first.index] != BodyType::Dynamic && records.type[def.second.index] != BodyType::Dynamic) {
    throw Error("JointDef: neither first " + text(def.first) + " nor second " + text(def.second) +
                " is dynamic; expected at least one that is");
  }
  // Joints know of masses that are the same in all directions only.
  for (const auto& [name, id] : {std::pair{"first", def.first}, std::pair{"second", def.second}}) {
    if (bodies.locks[id.index] == 0) continue;
    throw Error(std::string("JointDef.") + name + " is " + text(id) +
                ", which has motion locks; expected a body without, as joints don't know of them");
  }
}

JointId World::Impl::add_joint(const JointDef& definition) {
  check_bodies(definition);
  const JointDef def = checked(definition);
  solver::Joint joint = make_joint(def, records.centre[def.first.index], records.centre[def.second.index]);
  const solver::JointFrames frames = frames_of(joint);
  if (std::holds_alternative<DistanceJoint>(def.kind) && !(frames.offset.norm() > least_distance)) {
    throw Error("JointDef: the origins of the frames of a DistanceJoint coincide; expected two points");
  }
  find_positions(joint, frames);
  const std::uint32_t index = joints.add(def, joint);
  for (const BodyId body : {def.first, def.second}) joints.suspended[index] += quarantine.contains(body.index);
  joints.update_flags(index);
  joint_changed(index);
  if (!def.collide) keep_apart(index);
  return {index, joints.generation[index]};
}

void World::Impl::remove_joint(std::uint32_t joint) {
  joint_changed(joint);
  if (joints.enabled[joint] && !joints.def[joint].collide) let_touch(joint);
  joints.remove(joint);
}

// In order, as their indices are used again.
void World::Impl::remove_joints_of(std::uint32_t body) {
  std::vector<std::uint32_t> of_body;
  joints.for_each_of(body, [&](std::uint32_t joint) { of_body.push_back(joint); });
  std::sort(of_body.begin(), of_body.end());
  for (const std::uint32_t joint : of_body) remove_joint(joint);
}

// What removing them would do to all others: they wake and are solved anew.
void World::Impl::suspend_joints_of(std::uint32_t body) {
  joints.for_each_of(body, [this](std::uint32_t joint) {
    joint_changed(joint);
    ++joints.suspended[joint];
    joints.update_flags(joint);
    solver::Joint& j = joints.joints[joint];
    forget_impulses(j);
    j.force.setZero();
    j.torque.setZero();
    j.limit = {};
    joints.limit_before[joint] = {};
    find_positions(j, frames_of(j));
  });
}

void World::Impl::resume_joints_of(std::uint32_t body) {
  joints.for_each_of(body, [this](std::uint32_t joint) {
    joint_changed(joint);
    --joints.suspended[joint];
    joints.update_flags(joint);
    find_positions(joints.joints[joint], frames_of(joints.joints[joint]));
  });
}

solver::JointFrames World::Impl::frames_of(const solver::Joint& joint) const {
  return solver::joint_frames(joint, bodies.position(joint.first), bodies.orientation(joint.first),
                              bodies.position(joint.second), bodies.orientation(joint.second));
}

JointState World::Impl::joint_state(std::uint32_t index) const {
  const solver::Joint& joint = joints.joints[index];
  JointState state{.enabled = joints.enabled[index] != 0,
                   .broken = joints.broken[index] != 0,
                   .force = joint.force,
                   .torque = joint.torque};
  const std::span<const solver::Coordinate> names = named_coordinates(joints.def[index].kind);
  const solver::JointFrames frames = frames_of(joint);
  solver::Joint named = joint;
  std::copy(names.begin(), names.end(), named.coordinate.begin());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const solver::JointRow row = joint_row(named, i, frames);
    const std::size_t kept = row_along(joint, names[i]);
    state.position[i] = kept == joint.rows ? row.value : continued(names[i], row.value, joint.position[kept]);
    state.speed[i] = row.rate(bodies.velocity(joint.first), bodies.angular_velocity(joint.first),
                              bodies.velocity(joint.second), bodies.angular_velocity(joint.second));
  }
  return state;
}

void World::Impl::set_joint(std::uint32_t index, const JointKind& kind) {
  JointDef& def = joints.def[index];
  if (kind.index() != def.kind.index()) {
    throw Error(std::string("World::set_joint: kind is ") + name_of(kind) + "; expected " + name_of(def.kind) +
                ", as the joint was made with");
  }
  check("World::set_joint: kind", kind);
  wake_joined_by(index);
  def.kind = kind;
  solver::Joint& joint = joints.joints[index];
  const solver::Joint before = joint;
  const solver::Joint laws = make_joint(kind);
  joint.point = laws.point;
  joint.rows = laws.rows;
  joint.coordinate = laws.coordinate;
  joint.law = laws.law;
  joint.ratio = laws.ratio;
  if (!hold_the_same(before, joint)) {
    forget_impulses(joint);
    joint.limit = {};
    find_positions(joint, frames_of(joint));
    keep_state(before, joint);
    joints_stale_ = true;
  }
  joints.update_flags(index);
}

void World::Impl::set_joint_enabled(std::uint32_t joint, bool enabled) {
  if (enabled) joints.broken[joint] = 0;
  if (enabled == (joints.enabled[joint] != 0)) return;
  joint_changed(joint);
  joints.enabled[joint] = enabled;
  joints.update_flags(joint);
  joints.joints[joint].force.setZero();
  joints.joints[joint].torque.setZero();
  if (!enabled) {
    release(joint);
  } else if (!joints.def[joint].collide) {
    keep_apart(joint);
  }
}

// After the joint was disabled: it forgets what it did.
void World::Impl::release(std::uint32_t joint) {
  forget_impulses(joints.joints[joint]);
  joints.joints[joint].limit = {};
  joints.limit_before[joint] = {};
  if (!joints.def[joint].collide) let_touch(joint);
}

void World::Impl::joint_changed(std::uint32_t joint) {
  wake_joined_by(joint);
  joints_stale_ = true;
}

void World::Impl::wake_joined_by(std::uint32_t joint) {
  sleeping.wake(joints.joints[joint].first);
  sleeping.wake(joints.joints[joint].second);
}

void World::Impl::wake_joined(std::uint32_t body) {
  joints.for_each_of(body, [this](std::uint32_t joint) {
    if (joints.enabled[joint]) wake_joined_by(joint);
  });
}

// Bodies that were told not to touch don't either way.
void World::Impl::keep_apart(std::uint32_t joint) {
  const solver::Joint& j = joints.joints[joint];
  if (joints.keep_apart(j.first, j.second)) broadphase.ignore(j.first, j.second);
}

void World::Impl::let_touch(std::uint32_t joint) {
  const solver::Joint& j = joints.joints[joint];
  if (!joints.let_touch(j.first, j.second)) return;
  const auto told = records.ignored.find(j.first);
  const bool stay_apart = told != records.ignored.end() &&
                          std::find(told->second.begin(), told->second.end(), j.second) != told->second.end();
  if (!stay_apart) broadphase.unignore(j.first, j.second);
}

}  // namespace atl
