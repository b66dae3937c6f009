#pragma once

#include <solver/sweep/group_report.h>

#include <array>
#include <chrono>
#include <cstddef>

namespace atl::solver {

// Sums up where the time of a group goes, for those who ask.
class PhaseClock {
 public:
  PhaseClock(bool runs, std::array<double, solver_phase_count>& ms) : runs_(runs), ms_(ms) {
    if (runs_) last_ = std::chrono::steady_clock::now();
  }
  void lap(SolverPhase phase) {
    if (!runs_) return;
    const auto now = std::chrono::steady_clock::now();
    ms_[static_cast<std::size_t>(phase)] += std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
  }

 private:
  bool runs_;
  std::array<double, solver_phase_count>& ms_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace atl::solver
