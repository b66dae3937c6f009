#include <atoll/report.h>

namespace atl {

const char* phase_name(Phase phase) {
  switch (phase) {
    case Phase::Plan:
      return "plan";
    case Phase::FindPairs:
      return "find_pairs";
    case Phase::UpdateContacts:
      return "update_contacts";
    case Phase::BuildIslands:
      return "build_islands";
    case Phase::SolveIslands:
      return "solve_islands";
    case Phase::SweepFastBodies:
      return "sweep_fast_bodies";
    case Phase::Finish:
      return "finish";
  }
  return "";
}

const char* solver_phase_name(SolverPhase phase) {
  switch (phase) {
    case SolverPhase::Colour:
      return "colour";
    case SolverPhase::Prepare:
      return "prepare";
    case SolverPhase::WarmStart:
      return "warm_start";
    case SolverPhase::Solve:
      return "solve";
    case SolverPhase::Relax:
      return "relax";
    case SolverPhase::Integrate:
      return "integrate";
    case SolverPhase::Restitution:
      return "restitution";
    case SolverPhase::Store:
      return "store";
  }
  return "";
}

}  // namespace atl
