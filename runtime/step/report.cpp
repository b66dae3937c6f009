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

const char* solver_stage_name(SolverStage stage) {
  switch (stage) {
    case SolverStage::Colour:
      return "colour";
    case SolverStage::Prepare:
      return "prepare";
    case SolverStage::WarmStart:
      return "warm_start";
    case SolverStage::Solve:
      return "solve";
    case SolverStage::Relax:
      return "relax";
    case SolverStage::Integrate:
      return "integrate";
    case SolverStage::Restitution:
      return "restitution";
    case SolverStage::Store:
      return "store";
  }
  return "";
}

}  // namespace atl
