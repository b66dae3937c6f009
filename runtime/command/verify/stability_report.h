#pragma once

#include <iosfwd>
#include <span>

#include "checks/stability/suite.h"

namespace atl::command {

/// A line a criterion: case, criterion, value, limit, margin, ms a step, and "ok", "FAILS", "known failure" or "ok, no
/// longer a known failure". Then the reasons of known failures, and how many there are of each.
void write_stability_text(std::ostream& out, std::span<const stability::StabilityCase> cases,
                          std::span<const stability::CaseResult> results);

/// The same as one object. A value or margin that is not finite is null.
void write_stability_json(std::ostream& out, std::span<const stability::StabilityCase> cases,
                          std::span<const stability::CaseResult> results);

}  // namespace atl::command
