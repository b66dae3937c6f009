#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "variant_run.h"

namespace atl::divergence {

/// Told the number of steps done so far.
using OnStep = std::function<void(std::int64_t steps)>;

/// Hashes of a run as built and after each of the scene's steps.
std::vector<std::uint64_t> follow(const Scene& scene, const Variant& variant, const OnStep& on_step = {},
                                  const Meddle& meddle = {});

/// The first step after which a run differs from one that was followed, 0 as built; nothing if none does. Runs no
/// farther than that.
std::optional<std::int64_t> first_difference(const std::vector<std::uint64_t>& trail, const Scene& scene,
                                             const Variant& variant, const OnStep& on_step = {},
                                             const Meddle& meddle = {});

/// Something of a body that two worlds don't agree on.
struct PartDifference {
  /// "position", "orientation", "velocity", "angular_velocity", "forces", "rest", "bounds", "contacts" or "joints".
  std::string part;
  /// Size of the difference for the first four parts: m, rad, m/s, rad/s. 0 where only the sign of a zero differs.
  std::optional<double> by = {};
  std::string unit = {};
};

/// A body that two worlds don't agree on.
struct BodyDifference {
  std::size_t body;  ///< place in the scene's list
  std::vector<PartDifference> parts;
};

/// The point at which two runs of a scene diverge.
struct Divergence {
  std::int64_t step = 0;  ///< the first after which they differ; 0 as built
  /// True if they diverged in a second run, too. If not, the step is the first run's, and nothing below is known: a
  /// difference that comes and goes from run to run is a matter of timing.
  bool seen_again = false;
  bool events = false;                      ///< the state is the same, but not the events or their order
  bool elsewhere = false;                   ///< the state differs, but that of no body
  std::vector<BodyDifference> bodies = {};  ///< in the scene's order
};

/// Runs two variants again, next to each other, until they part or are past the step after which they were seen to.
Divergence explain(const Scene& scene, const Variant& first, const Variant& second, std::int64_t step,
                   const OnStep& on_step = {}, const Meddle& meddle = {});

/// Bodies that differ between two worlds that were built from one scene.
std::vector<BodyDifference> compare(const VariantRun& a, const VariantRun& b);

}  // namespace atl::divergence
