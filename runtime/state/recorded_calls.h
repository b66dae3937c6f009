#pragma once
/// Calls of World that change it, as values: what a recording (recorder.h) notes down and replay() makes again. Adding
/// bodies, restoring and stepping have more to tell, and records of their own (recording_file.h). A call that is new
/// goes to the end of RecordedCall, so that the numbers of the others stay.

#include <atoll/world.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "state/filter_state.h"
#include "state/joint_state.h"
#include "state/recording_file.h"
#include "state/settings_state.h"
#include "state/world_definition_state.h"

namespace atl::calls {

// Each has fields(self), all that it was called with, and make(world), the call.

struct RemoveBody {
  BodyId body;
  static auto fields(auto& self) { return std::tie(self.body); }
  void make(World& world) const { world.remove_body(body); }
};

struct SetPose {
  BodyId body;
  Pose pose;
  static auto fields(auto& self) { return std::tie(self.body, self.pose); }
  void make(World& world) const { world.set_pose(body, pose); }
};

struct SetVelocity {
  BodyId body;
  Vector3 linear;
  Vector3 angular;
  static auto fields(auto& self) { return std::tie(self.body, self.linear, self.angular); }
  void make(World& world) const { world.set_velocity(body, linear, angular); }
};

struct SetSurfaceVelocity {
  BodyId body;
  Vector3 velocity;
  Vector3 angular;
  static auto fields(auto& self) { return std::tie(self.body, self.velocity, self.angular); }
  void make(World& world) const { world.set_surface_velocity(body, velocity, angular); }
};

struct ApplyForce {
  BodyId body;
  Vector3 force;
  Vector3 torque;
  static auto fields(auto& self) { return std::tie(self.body, self.force, self.torque); }
  void make(World& world) const { world.apply_force(body, force, torque); }
};

struct ApplyImpulse {
  BodyId body;
  Vector3 impulse;
  Vector3 point;
  static auto fields(auto& self) { return std::tie(self.body, self.impulse, self.point); }
  void make(World& world) const { world.apply_impulse(body, impulse, point); }
};

struct Wake {
  BodyId body;
  static auto fields(auto& self) { return std::tie(self.body); }
  void make(World& world) const { world.wake(body); }
};

struct SetFilter {
  BodyId body;
  CollisionFilter filter;
  static auto fields(auto& self) { return std::tie(self.body, self.filter); }
  void make(World& world) const { world.set_filter(body, filter); }
};

struct SetCollisionEnabled {
  BodyId first;
  BodyId second;
  bool enabled;
  static auto fields(auto& self) { return std::tie(self.first, self.second, self.enabled); }
  void make(World& world) const { world.set_collision_enabled(first, second, enabled); }
};

struct Release {
  BodyId body;
  static auto fields(auto& self) { return std::tie(self.body); }
  void make(World& world) const { world.release(body); }
};

struct AddJoint {
  JointDef def;
  static auto fields(auto& self) { return std::tie(self.def); }
  void make(World& world) const { world.add_joint(def); }
};

struct RemoveJoint {
  JointId joint;
  static auto fields(auto& self) { return std::tie(self.joint); }
  void make(World& world) const { world.remove_joint(joint); }
};

struct SetJoint {
  JointId joint;
  JointKind kind;
  static auto fields(auto& self) { return std::tie(self.joint, self.kind); }
  void make(World& world) const { world.set_joint(joint, kind); }
};

struct SetMotorSpeed {
  JointId joint;
  double speed;
  std::uint64_t coordinate;
  static auto fields(auto& self) { return std::tie(self.joint, self.speed, self.coordinate); }
  void make(World& world) const { world.set_motor_speed(joint, speed, coordinate); }
};

struct SetServoTarget {
  JointId joint;
  double target;
  std::uint64_t coordinate;
  static auto fields(auto& self) { return std::tie(self.joint, self.target, self.coordinate); }
  void make(World& world) const { world.set_servo_target(joint, target, coordinate); }
};

struct SetJointEnabled {
  JointId joint;
  bool enabled;
  static auto fields(auto& self) { return std::tie(self.joint, self.enabled); }
  void make(World& world) const { world.set_joint_enabled(joint, enabled); }
};

struct CountTurnsFrom {
  JointId joint;
  double angle;
  std::uint64_t coordinate;
  static auto fields(auto& self) { return std::tie(self.joint, self.angle, self.coordinate); }
  void make(World& world) const { world.count_turns_from(joint, angle, static_cast<std::size_t>(coordinate)); }
};

struct SetGravity {
  Vector3 gravity;
  static auto fields(auto& self) { return std::tie(self.gravity); }
  void make(World& world) const { world.set_gravity(gravity); }
};

/// The instruction set is not of the recording but of who replays it.
struct SetSettings {
  Settings settings;
  static auto fields(auto& self) { return std::tie(self.settings); }
  void make(World& world) const {
    Settings all = settings;
    all.simd = world.settings().simd;
    world.set_settings(all);
  }
};

struct SetMaterial {
  BodyId body;
  Material material;
  static auto fields(auto& self) { return std::tie(self.body, self.material); }
  void make(World& world) const { world.set_material(body, material); }
};

struct SetMaterialPair {
  MaterialPair pair;
  static auto fields(auto& self) { return std::tie(self.pair); }
  void make(World& world) const { world.set_material_pair(pair); }
};

struct SetMass {
  BodyId body;
  double mass;
  static auto fields(auto& self) { return std::tie(self.body, self.mass); }
  void make(World& world) const { world.set_mass(body, mass); }
};

struct SetGravityScale {
  BodyId body;
  double scale;
  static auto fields(auto& self) { return std::tie(self.body, self.scale); }
  void make(World& world) const { world.set_gravity_scale(body, scale); }
};

struct SetDamping {
  BodyId body;
  double linear;
  double angular;
  static auto fields(auto& self) { return std::tie(self.body, self.linear, self.angular); }
  void make(World& world) const { world.set_damping(body, linear, angular); }
};

struct SetUserData {
  BodyId body;
  std::uint64_t data;
  static auto fields(auto& self) { return std::tie(self.body, self.data); }
  void make(World& world) const { world.set_user_data(body, data); }
};

struct SetName {
  BodyId body;
  std::string name;
  static auto fields(auto& self) { return std::tie(self.body, self.name); }
  void make(World& world) const { world.set_name(body, name); }
};

struct SetJointDefinition {
  JointId joint;
  JointDef def;
  static auto fields(auto& self) { return std::tie(self.joint, self.def); }
  void make(World& world) const { world.set_joint(joint, def); }
};

struct Refilter {
  BodyId body;
  static auto fields(auto& self) { return std::tie(self.body); }
  void make(World& world) const { world.refilter(body); }
};

struct SetEnabled {
  BodyId body;
  bool enabled;
  static auto fields(auto& self) { return std::tie(self.body, self.enabled); }
  void make(World& world) const { world.set_enabled(body, enabled); }
};

struct Sleep {
  BodyId body;
  static auto fields(auto& self) { return std::tie(self.body); }
  void make(World& world) const { world.sleep(body); }
};

struct SetHeights {
  BodyId body;
  std::uint32_t column, row, columns;
  std::vector<double> heights;
  static auto fields(auto& self) { return std::tie(self.body, self.column, self.row, self.columns, self.heights); }
  void make(World& world) const { world.set_heights(body, column, row, columns, heights); }
};

}  // namespace atl::calls

namespace atl {

using RecordedCall =
    std::variant<calls::RemoveBody, calls::SetPose, calls::SetVelocity, calls::SetSurfaceVelocity, calls::ApplyForce,
                 calls::ApplyImpulse, calls::Wake, calls::SetFilter, calls::SetCollisionEnabled, calls::Release,
                 calls::AddJoint, calls::RemoveJoint, calls::SetJoint, calls::SetJointEnabled, calls::SetGravity,
                 calls::SetSettings, calls::SetMaterial, calls::SetMass, calls::SetGravityScale, calls::SetDamping,
                 calls::SetUserData, calls::SetName, calls::Refilter, calls::CountTurnsFrom, calls::SetEnabled,
                 calls::Sleep, calls::SetJointDefinition, calls::SetHeights, calls::SetMaterialPair,
                 calls::SetMotorSpeed, calls::SetServoTarget>;

template <typename Archive, typename Field>
void visit_field(Archive& archive, Field& field) {
  using T = std::remove_const_t<Field>;
  if constexpr (std::is_same_v<T, BodyId> || std::is_same_v<T, JointId>) {
    archive.value(field.index);
    archive.value(field.generation);
  } else if constexpr (std::is_same_v<T, Vector3>) {
    archive.values(field.data(), 3);
  } else if constexpr (std::is_same_v<T, Quaternion>) {
    archive.values(field.coeffs().data(), 4);
  } else if constexpr (std::is_same_v<T, Pose>) {
    visit_field(archive, field.position);
    visit_field(archive, field.orientation);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    archive.list(field);
  } else if constexpr (std::is_same_v<T, std::string>) {
    visit_text(archive, field);
  } else if constexpr (std::is_same_v<T, Material>) {
    visit_material(archive, field);
  } else if constexpr (std::is_same_v<T, MaterialPair>) {
    visit_material_pair(archive, field);
  } else if constexpr (std::is_same_v<T, CollisionFilter>) {
    visit_filter(archive, field);
  } else if constexpr (std::is_same_v<T, JointKind>) {
    visit_kind(archive, field);
  } else if constexpr (std::is_same_v<T, JointDef>) {
    visit_definition(archive, field);
  } else if constexpr (std::is_same_v<T, Settings>) {
    visit_settings(archive, field);
  } else {
    archive.value(field);
  }
}

template <typename Archive, typename Call>
void visit_call(Archive& archive, Call& call) {
  std::apply([&](auto&... field) { (visit_field(archive, field), ...); }, std::remove_const_t<Call>::fields(call));
}

/// The place of a call in RecordedCall.
template <typename Call, std::size_t number = 0>
constexpr std::size_t number_of_call() {
  if constexpr (std::is_same_v<Call, std::variant_alternative_t<number, RecordedCall>>) {
    return number;
  } else {
    return number_of_call<Call, number + 1>();
  }
}

/// The kind of a call's records.
template <typename Call>
constexpr RecordKind kind_of() {
  return static_cast<RecordKind>(static_cast<std::size_t>(RecordKind::Call) + number_of_call<Call>());
}

}  // namespace atl
