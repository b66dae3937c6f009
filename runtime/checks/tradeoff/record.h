#pragma once

#include <atoll/closed_form.h>
#include <atoll/error.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace atl::tradeoff {

/// Thrown where a run that was timed ended in another state than the same one ahead of it, whose errors were measured.
class OtherBits : public Error {
 public:
  using Error::Error;
};

/// How a run ended.
enum class Outcome {
  Done,
  Fell,       ///< some body left its place for good, in a scene that starts at rest
  CameApart,  ///< a joint opened by more than max_joint_gap
  NonFinite,  ///< the state is no longer made of numbers
  Refused,    ///< the engine, or its driver, can't do this scene
  TooSlow,    ///< stopped at the limit of time
  Skipped,    ///< not tried, as the engine's settings before it took long enough
  Failed,     ///< the driver ended otherwise than it should
};

/// "done", "fell", "came_apart", "non_finite", "refused", "too_slow", "skipped", "failed".
const char* name_of(Outcome outcome);

/// A joint that opens by more in a run, m, holds nothing together any more: the run counts as broken.
inline constexpr double max_joint_gap = 1;

/// Times of the same work, done again and again.
class Samples {
 public:
  void add(double value) { values_.push_back(value); }
  std::size_t count() const { return values_.size(); }
  double median() const;  ///< of at least one
  double min() const;
  double max() const;

 private:
  std::vector<double> values_;
};

/// One setting of one engine in one scene.
struct Record {
  std::string engine = {};
  std::string label = {};                                         ///< "default", or what differs from it
  std::vector<std::pair<std::string, std::string>> options = {};  ///< axis and value, or the driver's options
  bool is_default = false;
  bool same_bits = false;  ///< as the engine's default: only the time can differ, and is all that was measured
  int threads = 1;
  int steps = 0;
  double dt = 0;  ///< s

  Outcome outcome = Outcome::Done;
  std::string why = {};  ///< where it is not Done
  std::vector<ErrorMeasure> errors = {};
  std::optional<std::uint64_t> hash = {};  ///< of the final state, where the engine has one
  double touching = 1;                     ///< touching_share() in the final state, of Atoll's runs
  Samples cpu = {};                        ///< s of CPU time a simulated second
  Samples wall = {};                       ///< ms a step

  /// Nothing where the run has none of that name. A signed mean counts by its size.
  std::optional<double> error(const std::string& name) const;
  /// Ends a run that is done otherwise where its errors tell of joints that came apart.
  void judge_joints();
  /// True if the run ended in a state that is worth timing, if not comparing.
  bool came_to_its_end() const {
    return outcome == Outcome::Done || outcome == Outcome::Fell || outcome == Outcome::CameApart;
  }
  /// True if error and time can be compared with those of other runs.
  bool comparable() const { return outcome == Outcome::Done && !same_bits && cpu.count() > 0; }
};

}  // namespace atl::tradeoff
