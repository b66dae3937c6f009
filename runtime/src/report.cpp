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

}  // namespace atl
