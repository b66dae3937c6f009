#pragma once
/// Events of a step: contacts and joints.

#include <solver/islands/joint_graph.h>

#include <span>
#include <vector>

#include "step/step_context.h"
#include "world/containment.h"
#include "world/stores.h"

namespace atl {

/// Tells settings by which a step keeps account of contacts that begin and end.
inline bool finds_contact_events(const Settings& settings) {
  return settings.contact_events || settings.run_everything;
}

/// Impulses and speeds of a step that events are made from; empty unless it finds them.
struct ContactPushes {
  std::span<const float> impulse;            ///< N s, by contact slot: see SolveInput::pushed
  std::span<const BodyVelocity> velocities;  ///< by body, as the step began; of those that are active
};

/// Keeps the velocities of active bodies before they are solved.
void keep_velocities(const Stores& world, std::vector<BodyVelocity>& velocities);
/// Adds the contacts that have pushed, but for those that touch as the step ends.
void add_hits(const Stores& world, const ContactPushes& pushes, bool ends_step, std::vector<ContactHit>& hits);
/// `hits`: what has touched within the step, however it ended; `pushes` are those of its last substep. Sorts the hits.
/// Tells which bodies fell asleep or woke since it last did.
void record_sleep_events(Stores& world);
void record_contact_events(Stores& world, const ContactPushes& pushes, std::vector<ContactHit>& hits,
                           bool islands_rebuilt, const StepContext& step);
/// Events of joints that act on awake bodies: a joint breaks, or reaches or leaves an end of its range. Asleep bodies
/// have none, since a body that a motor moves stays awake. Joints of bodies that the solve broke give no events.
void record_joint_events(Stores& world, std::span<const solver::JointLink> acting,
                         std::span<const QuarantineFault> broken);

}  // namespace atl
