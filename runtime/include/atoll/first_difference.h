#pragma once

#include <atoll/recording.h>
#include <atoll/report.h>
#include <atoll/settings.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace atl {

struct FirstDifferenceOptions {
  int threads = 1;  ///< workers of each replay, in [1, 1024]
  Simd simd = Simd::Auto;
};

/// The point at which two runs diverge.
struct FirstDifference {
  std::int64_t step = 0;  ///< the first after which their states differ
  bool by_calls = false;  ///< whether calls ahead of that step made them differ; else the step itself did
  /// The first step after which bodies differ: `step`, or a later one where what differs first is none of theirs, as
  /// settings. None if none ever do.
  std::optional<std::int64_t> bodies_step = {};
  /// The first phase of that step, in the order of a step, whose results differ: as counts of pairs, contacts and
  /// islands tell, and then bodies. None where calls made bodies different.
  std::optional<Phase> phase = {};
  std::vector<ReplayedBody> bodies = {};  ///< that differ then, in order of ids, and in what
};

struct FirstDifferenceResult {
  std::optional<FirstDifference> difference = {};  ///< none if they are the same as far as both go
  std::int64_t steps = 0;                          ///< that both have
  int replays = 0;                                 ///< that were made to find out
};

/// Finds the first step in which two recordings differ, by the hashes that they hold, replays both up to there, and
/// tells what is different. For runs of other settings, machines or builds: record each.
///
/// Throws Error as replay() does; and if a recording doesn't come to its own hashes when it is replayed here, saying
/// from which step on.
FirstDifferenceResult find_first_difference(const std::string& first, const std::string& second,
                                            const FirstDifferenceOptions& options = {});

}  // namespace atl
