// Joints of a state that is taken on: see restore.cpp.

#include "state/joint_state.h"
#include "state/state_archive.h"
#include "world/joint_definition.h"
#include "world/make_joint.h"
#include "world/world_impl.h"

namespace atl {

// As a state has it.
std::span<const std::byte> World::Impl::definition_bytes(std::uint32_t joint) {
  StateWriter writer(definition_bytes_);
  visit_definition(writer, joints.def[joint]);
  return {definition_bytes_.data(), writer.size()};
}

void World::Impl::restore_joint(std::uint32_t joint, const JointDef& def) {
  check_bodies(def);
  checked(def);
  joints.def[joint] = def;
  joints.joints[joint] = make_joint(def, records.centre[def.first.index], records.centre[def.second.index]);
}

// All joints are there as they were saved; `same` if the world had them before.
void World::Impl::restore_joints(bool same) {
  restored_acts_ = joints.acts;
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    if (!joints.alive[joint]) {
      joints.joints[joint] = {};
      joints.def[joint] = {};
      joints.enabled[joint] = joints.broken[joint] = joints.suspended[joint] = 0;
      continue;
    }
    const solver::Joint& j = joints.joints[joint];
    joints.suspended[joint] =
        static_cast<std::uint8_t>(int{quarantine.contains(j.first)} + int{quarantine.contains(j.second)});
    joints.update_flags(joint);
  }
  if (!same) joints.rebuild();
  joints_stale_ |= !same || joints.acts != restored_acts_;
}

}  // namespace atl
