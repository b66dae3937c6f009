#pragma once

#include <solver/constraints/joint.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

#include <span>

namespace atl::solver {

/// Whether joints that hang together are to be solved at once. `Auto`: where they are joined to something fixed or
/// kinematic, where one is actuated, sprung or without a fixed point, where a body is light, or turns easily, between
/// others that its joints hold to it, and in long chains. `joints` are all.
bool joins_directly(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies,
                    JointMethod method);

}  // namespace atl::solver
