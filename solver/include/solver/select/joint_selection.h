#pragma once

#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

#include <span>

namespace atl::solver {

/// Whether joints that hang together are to be solved at once. `Auto`: where they are joined to something fixed or
/// kinematic, where two joined bodies differ much in mass, and in long chains.
bool joins_directly(std::span<const JointLink> links, const BodyTable& bodies, JointMethod method);

}  // namespace atl::solver
