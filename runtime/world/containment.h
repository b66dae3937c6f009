#pragma once
/// Containment: a body whose state is no longer finite, or absurd, is taken out of the world as if it had been removed,
/// so that everything else goes on as it would without it.

#include <solver/integrate/motion.h>

#include <cstdint>
#include <utility>
#include <vector>

#include "world/stores.h"

namespace atl {

/// A body, and what is wrong with it.
using QuarantineFault = std::pair<std::uint32_t, Quarantine>;

/// A new body: the next step checks it. What is static is checked at once, and stays so unless a caller touches it.
void suspect_new(Stores& world, std::uint32_t body);
/// Before a caller moves a body: should it be moved where nothing can be, it is to be found where it was.
void before_move(Stores& world, std::uint32_t body, const Vector3& position);
/// At the start of a step, of the bodies that callers touched: those that fail meet nothing. Returns these, in order.
std::vector<QuarantineFault> quarantine_suspects(Stores& world);
/// After the solve: what came out of it unsound is where the step found it, and still, for the rest of the step. Lists
/// these in `broken`, in order, and takes them off the list of bodies that moved.
void restrain_broken(Stores& world, solver::FastBodies& moved, std::vector<QuarantineFault>& broken);
void put_in_quarantine(Stores& world, std::uint32_t body, Quarantine reason);
/// Throws Error if the body isn't in quarantine, or has to stay there.
void release_body(Stores& world, std::uint32_t body);
/// See World::set_enabled().
void set_enabled(Stores& world, std::uint32_t body, bool enabled);

}  // namespace atl
