#pragma once
/// Calls of World that change it, as values: what a recording (recorder.h) notes down and replay() makes again. Adding
/// bodies, restoring and stepping have more to tell, and records of their own (recording_file.h). A call that is new
/// goes to the end of RecordedCall, so that the numbers of the others stay.

#include <atoll/world.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
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

// Arguments are kept by value.
template <typename T>
T keep(const T& argument) {
  return argument;
}
inline std::string keep(std::string_view text) { return std::string(text); }
inline std::vector<double> keep(std::span<const double> numbers) { return {numbers.begin(), numbers.end()}; }
inline std::uint64_t keep(std::size_t number) { return number; }

template <typename... Argument>
struct Arguments {
  std::tuple<decltype(keep(std::declval<Argument>()))...> kept;

  Arguments() = default;
  explicit Arguments(Argument... given) : kept(keep(given)...) {}

  void pass_to(const auto& function) const {
    std::apply([&](const auto&... one) { function(static_cast<Argument>(one)...); }, kept);
  }
};

/// One call: of a function of World, or of one that takes the world ahead of the arguments. make(world) calls it.
template <auto function>
struct Call;

template <typename Result, typename... Argument, Result (World::*function)(Argument...)>
struct Call<function> : Arguments<Argument...> {
  using Arguments<Argument...>::Arguments;
  void make(World& world) const {
    this->pass_to([&](Argument... argument) { (world.*function)(argument...); });
  }
};

template <typename... Argument, void (*function)(World&, Argument...)>
struct Call<function> : Arguments<Argument...> {
  using Arguments<Argument...>::Arguments;
  void make(World& world) const {
    this->pass_to([&](Argument... argument) { function(world, argument...); });
  }
};

/// Chooses one of several functions of World by its arguments.
template <typename... Argument>
constexpr auto overload(void (World::*function)(Argument...)) {
  return function;
}

/// The instruction set is not of the recording but of who replays it.
inline void set_settings(World& world, const Settings& settings) {
  Settings all = settings;
  all.simd = world.settings().simd;
  world.set_settings(all);
}

using RemoveBody = Call<&World::remove_body>;
using SetPose = Call<&World::set_pose>;
using SetVelocity = Call<&World::set_velocity>;
using SetSurfaceVelocity = Call<&World::set_surface_velocity>;
using ApplyForce = Call<&World::apply_force>;
using ApplyImpulse = Call<&World::apply_impulse>;
using Wake = Call<&World::wake>;
using SetFilter = Call<&World::set_filter>;
using SetCollisionEnabled = Call<&World::set_collision_enabled>;
using Release = Call<&World::release>;
using AddJoint = Call<&World::add_joint>;
using RemoveJoint = Call<&World::remove_joint>;
using SetJoint = Call<overload<JointId, const JointKind&>(&World::set_joint)>;
using SetJointEnabled = Call<&World::set_joint_enabled>;
using SetGravity = Call<&World::set_gravity>;
using SetSettings = Call<&set_settings>;
using SetMaterial = Call<&World::set_material>;
using SetMass = Call<&World::set_mass>;
using SetGravityScale = Call<&World::set_gravity_scale>;
using SetDamping = Call<&World::set_damping>;
using SetUserData = Call<overload<BodyId, std::uint64_t>(&World::set_user_data)>;
using SetName = Call<overload<BodyId, std::string_view>(&World::set_name)>;
using Refilter = Call<&World::refilter>;
using CountTurnsFrom = Call<&World::count_turns_from>;
using SetEnabled = Call<&World::set_enabled>;
using Sleep = Call<&World::sleep>;
using SetJointDefinition = Call<overload<JointId, const JointDef&>(&World::set_joint)>;
using SetHeights = Call<&World::set_heights>;
using SetMaterialPair = Call<&World::set_material_pair>;
using SetMotorSpeed = Call<&World::set_motor_speed>;
using SetServoTarget = Call<&World::set_servo_target>;

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
  if constexpr (std::is_same_v<T, std::vector<double>>) {
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
    visit_value(archive, field);
  }
}

template <typename Archive, typename Call>
void visit_call(Archive& archive, Call& call) {
  std::apply([&](auto&... field) { (visit_field(archive, field), ...); }, call.kept);
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
