// What the step does about joints besides solving them.

#include <solver/select/joint_selection.h>

#include <algorithm>

#include "world/settings_check.h"
#include "world/world_impl.h"

namespace atl {

// Joints or how they are solved changed.
void World::Impl::update_joint_graph() {
  if (!joints_stale_) return;
  joints_stale_ = false;
  islands_stale_ = true;
  joint_graph_.build(joints.joints, joints.acts, bodies);
  const solver::JointMethod method = solver_settings(settings).joint_method;
  joint_systems_.build(joint_graph_, joints.joints, bodies, [&](std::uint32_t component) {
    return solver::joins_directly(joint_graph_.links_of(component), bodies, method);
  });
  to_kinematic_.clear();
  assembly_.resize(bodies.size());
  std::fill(bodies.joined.begin(), bodies.joined.end(), std::uint8_t{0});
  for (const solver::JointLink& link : joint_graph_.links()) {
    for (const std::uint32_t body : {link.first, link.second}) {
      bodies.joined[body] = records.dynamic[body];
      assembly_[body] = joint_graph_.component_of(link.joint);
    }
    if (bodies.mobility[link.first] == solver::Mobility::Kinematic) to_kinematic_.push_back({link.first, link.second});
    if (bodies.mobility[link.second] == solver::Mobility::Kinematic) to_kinematic_.push_back({link.second, link.first});
  }
}

// What hangs on a moving body doesn't rest, however slow that is.
void World::Impl::wake_joined_to_moving() {
  for (const auto& [kinematic, other] : to_kinematic_) {
    if (active_.contains(kinematic)) sleeping.wake(other);
  }
}

std::span<const solver::JointLink> World::Impl::acting_joints() const { return islands_.joints(0, islands_.count()); }

void World::Impl::count_joints() {
  const std::span<const solver::JointLink> acting = acting_joints();
  if (islands_rebuilt_) {
    direct_joints_ = std::count_if(acting.begin(), acting.end(), [this](const solver::JointLink& link) {
      return joint_systems_.is_direct(joint_graph_.component_of(link.joint));
    });
  }
  report_.counts.joints = static_cast<std::int64_t>(acting.size());
  report_.counts.direct_joints = direct_joints_;
}

void World::Impl::note_joints() {
  for (const solver::JointLink& link : acting_joints()) {
    if (joints.watched[link.joint]) watch_joint(link.joint);
    if (settings.sleeping && joints.driven[link.joint]) keep_driven_awake(link.joint);
  }
  // Islands come in order of their bodies.
  std::stable_sort(joint_events_.begin(), joint_events_.end(),
                   [](const JointEvent& a, const JointEvent& b) { return a.joint < b.joint; });
}

void World::Impl::watch_joint(std::uint32_t joint) {
  const solver::Joint& j = joints.joints[joint];
  const JointId id{joint, joints.generation[joint]};
  const JointTable::Limits before = joints.limit_before[joint];
  joints.limit_before[joint] = j.limit;
  if (j.force.norm() > joints.def[joint].break_force || j.torque.norm() > joints.def[joint].break_torque) {
    joints.broken[joint] = 1;
    joints.enabled[joint] = 0;
    joints.update_flags(joint);
    joint_changed(joint);
    release(joint);
    joint_events_.push_back({id, JointEventKind::Broke});
    return;
  }
  bool reached = false;
  bool left = false;
  for (std::size_t row = 0; row < j.rows; ++row) {
    if (j.limit[row] == before[row]) continue;
    reached |= j.limit[row] != 0;
    left |= before[row] != 0;
  }
  if (left) joint_events_.push_back({id, JointEventKind::LeftLimit});
  if (reached) joint_events_.push_back({id, JointEventKind::ReachedLimit});
}

// However slow a motor runs, what it moves is not at rest; what it fails to move may be.
void World::Impl::keep_driven_awake(std::uint32_t joint) {
  const solver::Joint& j = joints.joints[joint];
  const solver::JointFrames frames = frames_of(j);
  for (std::size_t row = 0; row < j.rows; ++row) {
    const solver::Law& law = j.law[row];
    if (!(law.motor_force > 0 && law.motor_speed != 0)) continue;
    const double rate = joint_row(j, row, frames)
                            .rate(bodies.velocity(j.first), bodies.angular_velocity(j.first), bodies.velocity(j.second),
                                  bodies.angular_velocity(j.second));
    if (rate / law.motor_speed > 0.5) wake_joined_by(joint);
  }
}

}  // namespace atl
