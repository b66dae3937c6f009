#include <atoll/report.h>

namespace atl {

const char* phase_name(Phase phase) {
  constexpr std::array<const char*, phase_count> names = {
      "plan", "find_pairs", "update_contacts", "build_islands", "solve_islands", "sweep_fast_bodies", "finish"};
  return names[static_cast<std::size_t>(phase)];
}

const char* solver_phase_name(SolverPhase phase) {
  constexpr std::array<const char*, solver_phase_count> names = {"colour", "prepare",   "warm_start",  "solve",
                                                                 "relax",  "integrate", "restitution", "store"};
  return names[static_cast<std::size_t>(phase)];
}

}  // namespace atl
