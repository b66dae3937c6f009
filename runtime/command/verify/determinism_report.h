#pragma once

#include <atoll/scene.h>

#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "checks/divergence/divergence.h"

namespace atl::command {

/// A run that was held to the baseline.
struct VariantResult {
  divergence::Variant variant;
  std::optional<divergence::Divergence> divergence;  ///< nothing if all its bits are the baseline's
};

struct DeterminismResult {
  divergence::Variant baseline;
  std::uint64_t hash = 0;  ///< after its last step
  std::vector<VariantResult> others;
};

/// `step 41, body 17 "crate": position by 1.1e-16 m, contacts`.
std::string first_words(const Scene& scene, const divergence::Divergence& divergence);

/// A line a run: threads, instruction set, where some runs are restored into which world, and "same" or where it parts;
/// then the bodies that differ there.
void write_determinism_text(std::ostream& out, const Scene& scene, const DeterminismResult& result);
/// The same as one object.
void write_determinism_json(std::ostream& out, const Scene& scene, const DeterminismResult& result);

}  // namespace atl::command
