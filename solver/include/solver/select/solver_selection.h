#pragma once

#include <jobs/arena.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <solver/select/load_estimate.h>

#include <cstdint>
#include <span>

namespace atl::solver {

/// The ways to solve an island.
enum class SolveMode : std::uint8_t {
  Sweep,    ///< with the substeps of the settings
  Refined,  ///< in more substeps
  Landing,  ///< in more substeps, for a step in which something lands
  Direct,   ///< at once
};

/// The factor of substeps for an island that sags, a power of two; 1 if the substeps asked for are as short already.
int refinement_of(const SolverSettings& settings, double dt);

/// Chooses how each island is solved, by one rule. Where soft contacts would overlap by more than their budget under
/// what lies on them (LoadEstimate), the island is solved at once if it is small and either little but columns or deep
/// in what it presses on. Otherwise, if a large part of it is beyond the budget, it gets finer substeps. The budgets
/// are parts of the bodies' size: tuning::column_penetration, tuning::overload_penetration and
/// tuning::deep_penetration.
///
/// Three things don't follow from loads: joints and contacts that would undo what the other did are solved at once, so
/// is a body that turns alone on what it leans on, and one that lands alone meanwhile gets finer substeps in that step.
/// An island that could not be solved at once is swept for tuning::failed_time.
class SolverSelection {
 public:
  /// Makes room for so many bodies. Must come before a choice in which something moves.
  void resize(std::size_t bodies);
  /// One that is gone.
  void forget(std::uint32_t body);
  void forget_all();

  /// Chooses modes by island such that every island that can be is solved at once.
  std::span<const SolveMode> choose_direct(const LoadInput& input);

  /// Chooses the modes of islands for the next step; empty if all are to be swept.
  std::span<const SolveMode> choose(const LoadInput& input, jobs::Arena& arena);

  /// Chooses modes where contacts are swept whatever they carry: only islands of joints alone are solved at once.
  std::span<const SolveMode> choose_untouched(const LoadInput& input);

  /// Why an island got its mode, by the last choice; in words, static storage.
  const char* why(std::size_t island) const;

  /// An island that choose_direct() left to sweeps, and why, likewise.
  struct Refused {
    std::size_t island;
    const char* why;
  };
  std::span<const Refused> refused() const { return refused_; }

  /// Records, after a step of dt seconds, the bodies of islands that could not be solved at once, in any order. Time
  /// stands still for bodies that sleep.
  void record_failed(std::span<const std::uint32_t> failed, std::span<const std::uint8_t> awake, double dt);

  /// The last result for a body's island. It is kept from step to step.
  struct Finding {
    SolveMode mode = SolveMode::Sweep;  ///< by the last estimate of its load: Sweep, Refined or Direct
    float swept = 0;                    ///< s: for how long yet, after it could not be solved at once
    std::uint32_t bodies = 0;           ///< of that island; 0 before the first estimate
    bool operator==(const Finding&) const = default;
  };
  Finding finding(std::uint32_t body) const { return body < findings_.size() ? findings_[body] : Finding{}; }
  /// Restores the finding of a saved state. Bodies come in order.
  void restore(std::uint32_t body, const Finding& finding);

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(findings_, failed_, modes_, joined_, landings_, turning_, is_on_system_, refused_);
  }

 private:
  void find_motions(const LoadInput& input);
  void find_joined(const LoadInput& input, bool touched);
  void start_modes(const Islands& islands);
  void begin_without_loads(const LoadInput& input);
  bool is_joined(std::size_t island) const;
  SolveMode mode_by_load(const LoadInput& input, std::size_t island);
  bool is_machine(const LoadInput& input, std::size_t island);
  bool is_pushed_on(const LoadInput& input, std::size_t island);

  // Lists the members that last from step to step, then (after the empty comment) scratch. A new member has to be put
  // into one of the two lists, or this doesn't compile.
  static void check_members(SolverSelection& selection) {
    auto& [findings, failed, /**/ landings, turning, joined, on_system, modes, refused] = selection;
    static_cast<void>(findings);
  }

  jobs::CompactArray<Finding> findings_;           // by body
  jobs::CompactArray<std::uint32_t> failed_;       // bodies that are swept for some time, in order
  jobs::CompactArray<std::size_t> landings_;       // islands in which something lands
  jobs::CompactArray<std::size_t> turning_;        // those in which contacts turn far
  jobs::CompactArray<std::size_t> joined_;         // islands that are solved at once for the sake of their joints
  jobs::CompactArray<std::uint8_t> is_on_system_;  // by body of an island
  jobs::CompactArray<SolveMode> modes_;            // by island
  jobs::CompactArray<Refused> refused_;
};

}  // namespace atl::solver
