#pragma once
/// Physical laws that a run is held against: closed forms, published values, and integrations of the equations of
/// motion that share nothing with the solver.

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace atl::physics {

/// How finely a case is run.
struct Resolution {
  double dt = 1.0 / 60;  ///< s
  int substeps = 4;
};

struct PhysicsCase {
  std::string name;  ///< unique, of lower-case words and numbers with '-' between
  std::string what;  ///< one line
  std::string unit;  ///< of the value: "m", "rad", "m/s", or "" for a ratio
  double right = 0;  ///< what the value should be
  std::string source;
  double scale = 1;      ///< what the error is relative to, in the unit
  double limit = 0.01;   ///< of the error
  double dt = 1.0 / 60;  ///< s, at which the limit is to hold
  /// The value that a run at this resolution comes to: deterministic, on one thread. Not finite where a body is lost.
  std::function<double(const Resolution&)> measure;
  bool statistical = false;        ///< of many bodies: the value scatters, and finer steps tell no more of it
  std::string known_failure = {};  ///< the reason why the error is above the limit as things stand, else ""
  std::string known_growth = {};   ///< the reason why finer steps have a larger error as things stand, else ""
};

/// The result of a case.
struct PhysicsResult {
  double value = 0;
  double error = 0;    ///< |value - right| / scale
  double seconds = 0;  ///< of the run

  bool holds(const PhysicsCase& test) const { return error <= test.limit; }  ///< so NaN does not
  /// True if the case holds, or is known not to. A known failure that holds is no longer one, and has to be reported.
  bool expected(const PhysicsCase& test) const { return holds(test) == test.known_failure.empty(); }
};

/// The runs of a case.
struct CaseRuns {
  std::vector<PhysicsResult> own;  ///< at the case's step, and in finer ones that are asked for
  PhysicsResult by_default;        ///< at the step that Resolution has
};

/// Returns true if the last of runs in finer and finer steps is farther off than the first, by more than rounding.
bool grows(std::span<const PhysicsResult> runs);
/// Returns true if all is as it should be: the first run holds, and finer ones are not farther off, or are known to be.
/// A known growth that is none any more has to be told, too.
bool expected(const PhysicsCase& test, std::span<const PhysicsResult> runs);

/// All cases, in the order to show them.
const std::vector<PhysicsCase>& physics_cases();

/// Runs it at `dt`, or at its own if that is 0.
PhysicsResult run_case(const PhysicsCase& test, double dt = 0);

}  // namespace atl::physics
