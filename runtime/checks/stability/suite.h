#pragma once
/// Stiff and extreme scenes, each with numbers that its run must keep below.

#include <atoll/scene.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace atl::stability {

/// A run of a scene as criteria see it.
struct History {
  const Scene& scene;
  std::vector<std::vector<BodyState>> states;  ///< of the scene's bodies, at the start and after each step
};

/// A number that a run must not exceed. It is set from what the scene asks for, not from what a run came to, and stays
/// where a run exceeds it: then it says why.
struct Criterion {
  std::string name;  ///< as "penetration"
  std::string unit;  ///< "m", "rad", "m/s", or "" for a ratio or a count
  double limit = 0;
  std::function<double(const History&)> measure;
  std::string known_failure = {};  ///< the reason why it is exceeded as things stand, else ""
};

struct StabilityCase {
  std::string name;  ///< unique, of lower-case words and numbers with '-' between
  std::string what;  ///< one line
  /// Deterministic; the scene runs at its own dt and settings, which are the defaults unless `what` says otherwise.
  std::function<Scene()> build;
  int steps = 300;
  std::vector<Criterion> criteria;
};

/// The result of a criterion.
struct Finding {
  std::string criterion;
  std::string unit;
  double limit = 0;
  double value = 0;  ///< infinite if some body's state ceased to be one
  std::string known_failure = {};

  bool holds() const { return value <= limit; }  ///< so NaN does not
  double margin() const;                         ///< limit over value, infinite where the value is 0
  /// True if the criterion holds, or is known not to. A known failure that holds is no longer one, and has to be
  /// reported.
  bool expected() const { return holds() == known_failure.empty(); }
};

/// The first bad state: it became non-finite or absurd, so that the body was quarantined, or an orientation lost its
/// length.
struct BadState {
  int step = 0;          ///< 1 is the first
  std::size_t body = 0;  ///< place in the scene
};

struct CaseResult {
  std::vector<Finding> findings;  ///< in the order of the criteria
  double ms_per_step = 0;         ///< median
  double worst_step = 0;          ///< the longest step over the median
  std::optional<BadState> bad_state = {};

  bool failed() const;  ///< something does not hold that is not known to fail
};

/// All cases, in the order to show them.
const std::vector<StabilityCase>& stability_cases();

/// Runs it on one thread and measures. Throws SceneError if the scene cannot be built.
CaseResult run_case(const StabilityCase& test);

}  // namespace atl::stability
