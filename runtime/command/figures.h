#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "simulation.h"

namespace atl::command {

/// The figures of a run under the names that both reports give them, in their order.

struct Count {
  const char* name;
  std::int64_t value;
};
std::vector<Count> named_counts(const StepCounts& counts);

/// "penetration", "joint_gap", "residual", "motion".
const char* name_of(TargetError error);
/// "m", "m/s" or "".
const char* unit_of(TargetError error);
double limit_of(const ErrorTarget& target, TargetError error);

struct BodyCounts {
  std::int64_t dynamic = 0;
  std::int64_t fixed = 0;
  std::int64_t kinematic = 0;
};
BodyCounts body_counts(const Scene& scene);

/// `body 3 "crate"`, by its place in the scene's list.
std::string body_words(const Scene& scene, std::size_t body);

/// `body 3 "crate" was quarantined in step 7 of 60: its speed is above 1e6 m/s`.
std::string lost_words(const Scene& scene, const LostBody& lost);

}  // namespace atl::command
