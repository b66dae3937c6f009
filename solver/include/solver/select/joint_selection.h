#pragma once

#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

#include <span>

namespace atl::solver {

/// The most that one of two bodies which joints or contacts hold may weigh of the other, where these are solved one by
/// one.
inline constexpr double light_ratio = 10;

/// Whether joints that hang together are to be solved at once. `Auto`: where they are joined to something fixed or
/// kinematic, where two joined bodies differ much in mass, and in long chains.
bool joins_directly(std::span<const JointLink> links, const BodyTable& bodies, JointMethod method);

}  // namespace atl::solver
