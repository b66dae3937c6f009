#pragma once
/// What a step tells of contacts that began and ended, and of joints.

#include <solver/islands/joint_graph.h>

#include <cstdint>
#include <span>
#include <utility>
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
void note_contact_events(Stores& world, const ContactPushes& pushes, std::vector<ContactHit>& hits,
                         bool islands_rebuilt, const StepContext& step);
/// Of joints that act on awake bodies: those that break, and that reach or leave ends of their ranges. What a motor
/// moves stays awake. Those of bodies that the solve broke tell nothing.
void note_joint_events(Stores& world, std::span<const solver::JointLink> acting,
                       std::span<const QuarantineFault> broken);

}  // namespace atl
