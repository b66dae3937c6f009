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

/// Adds the pairs of bodies whose contacts have pushed, by slot, but for those that touch as the step ends; where none
/// is asked for, `pushed` is empty.
void add_hits(const Stores& world, std::span<const std::uint8_t> pushed, bool ends_step,
              std::vector<std::pair<BodyId, BodyId>>& hits);
/// `hits`: what has touched within the step, however it ended.
void note_contact_events(Stores& world, std::span<const std::pair<BodyId, BodyId>> hits, bool islands_rebuilt,
                         const StepContext& step);
/// Of joints that act on awake bodies: those that break, and that reach or leave ends of their ranges. What a motor
/// moves stays awake. Those of bodies that the solve broke tell nothing.
void note_joint_events(Stores& world, std::span<const solver::JointLink> acting,
                       std::span<const QuarantineFault> broken);

}  // namespace atl
