#pragma once

#include <array>
#include <iosfwd>
#include <span>
#include <vector>

#include "checks/physics/suite.h"

namespace atl::command {

/// A case's own step by these, where finer ones are asked for too.
inline constexpr std::array refinements = {1, 4, 16, 64};

/// A line a case: what is right, what the run came to, its error and limit, "ok", "FAILS", "known failure" or "ok, no
/// longer a known failure", ms, and the error at the default step; with finer steps, the error at each, and "GROWS in
/// finer steps" or "ok, no longer known to grow". Then the reasons of known failures.
void write_physics_text(std::ostream& out, std::span<const physics::PhysicsCase> cases,
                        std::span<const physics::CaseRuns> results);

/// The same as one object, with what each case is and its source. A value or error that is not finite is null.
void write_physics_json(std::ostream& out, std::span<const physics::PhysicsCase> cases,
                        std::span<const physics::CaseRuns> results);

}  // namespace atl::command
