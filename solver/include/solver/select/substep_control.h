#pragma once

#include <jobs/arena.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <solver/select/error_target.h>
#include <solver/select/island_errors.h>
#include <solver/select/motion_error.h>

#include <cstdint>
#include <span>

namespace atl::solver {

/// Gives each island the fewest substeps that hold its errors within targets, from what the last step left: more at
/// once, where an error is beyond its target for two steps; fewer once nothing has needed as many for
/// tuning::target_hold, or for longer where that was too few before.
///
/// Errors of soft contacts and joints fall with the square of the substeps (see tests/law), so one look tells how many
/// it takes, with tuning::target_margin to spare, and what was chosen stays: the rule of step size control (Hairer,
/// Norsett and Wanner, "Solving Ordinary Differential Equations I", II.4). For contacts by an embedded error estimate
/// see "CENIC" (Castro et al., arXiv 2511.08771, 2025).
///
/// A body carries what its island was given. Islands that merge get the most of theirs, those that part keep it.
class SubstepControl {
 public:
  /// The state by body that is kept from step to step.
  struct History {
    std::uint16_t substeps = 0;  ///< of the last step that its island took; 0: none yet
    std::uint16_t max = 0;       ///< largest need in the time looked at
    std::uint16_t asked = 0;     ///< need by the errors at the last step's end
    std::uint16_t needed = 0;    ///< need as that step began
    float looked_at = 0;         ///< s
    float hold = 0;              ///< s, for which it has to need fewer until it gets them
    float unchanged = 0;         ///< s
    bool lowered = false;        ///< its last change was to fewer
    bool operator==(const History&) const = default;
    /// Takes over the history of an island that merges with this one. A trial of either says nothing about both
    /// together.
    void join(const History& other);
  };

  enum class Error : std::uint8_t { Penetration, JointGap, Residual, Motion };

  /// The substeps of an island in the last step.
  struct Island {
    std::uint16_t substeps = 0;  ///< number that it got, of all of a step
    std::uint16_t needed = 0;    ///< number that would hold its targets, as far as substeps do; above it at the cap
    bool settles = false;        ///< the number has just changed
  };

  /// An error of an island beyond its target.
  struct Miss {
    std::uint32_t island;
    Error error;
    double measured;
  };

  bool is_empty() const { return history_.empty(); }
  /// Drops all history, once there is no target to hold.
  void forget_all();
  void forget(std::uint32_t body) {
    if (body < history_.size()) history_[body] = {};
    motion_.forget(body);
  }

  /// Chooses the substeps of each island of the step that begins; see Island::substeps.
  std::span<const Island> choose(const ErrorInput& input, const ErrorTarget& target, jobs::Arena& arena);
  /// Records the errors as the step ends. `residuals` are by island, or empty if they were not measured.
  void note(const ErrorInput& input, const ErrorTarget& target, std::span<const double> residuals);

  std::span<const Island> islands() const { return islands_; }
  std::span<const Miss> misses() const { return misses_; }  ///< of the last step, by island and error

  const History& history(std::uint32_t body) const;
  /// Restores the history of a body from a saved state.
  void restore_history(std::uint32_t body, std::size_t bodies, const History& history);
  MotionError& motion() { return motion_; }
  const MotionError& motion() const { return motion_; }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(history_, substeps_, islands_, misses_, needs_, counts_, motion_); }

 private:
  struct Needs {
    ErrorNeed overlap, gap;
  };

  void measure(const ErrorInput& input, const ErrorTarget& target, jobs::Arena& arena);
  ErrorNeed overlap_of_large(const ErrorInput& input, const ErrorTarget& target, std::size_t island,
                             jobs::Arena& arena);
  void decide(const ErrorInput& input, const ErrorTarget& target, std::size_t island);
  void record_residuals(const ErrorInput& input, const ErrorTarget& target, std::span<const double> residuals);
  void record_motion(const ErrorInput& input, const ErrorTarget& target);

  // Lists the members that last from step to step, then (after the empty comment) scratch. A new member has to be put
  // into one of the two lists, or this doesn't compile.
  static void check_members(SubstepControl& control) {
    auto& [history, motion, /**/ substeps, islands, misses, needs, counts] = control;
    static_cast<void>(history);
  }

  jobs::CompactArray<History> history_;  // by body; empty while there is no target
  MotionError motion_;
  jobs::CompactArray<std::uint16_t> substeps_;  // by body: of the last step
  jobs::CompactArray<Island> islands_;
  jobs::CompactArray<Miss> misses_;
  jobs::CompactArray<Needs> needs_;         // by island
  jobs::CompactArray<ErrorCounts> counts_;  // of the parts of a large island
};

}  // namespace atl::solver
