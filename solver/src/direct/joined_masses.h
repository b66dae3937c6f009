#pragma once
/// How heavy coordinates are for the springs, servos and dampers along them.

#include <solver/direct/balance_search.h>
#include <solver/direct/island_problem.h>

namespace atl::solver {

/// Finds how heavy the coordinates of dampers and stiff springs are with all that is joined, where that matters in a
/// substep of h seconds, and which share of that is left to each where several act on the same motion: N springs side
/// by side act as one of N times the stiffness. With rows in place and before they have laws, so that locks and
/// armatures alone act, and nothing touches. Rates tell if servos give all that they have.
void weigh_joined(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search);

/// Does so only for springs that would move bodies too far in a substep, all together.
void weigh_crowded(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search);

/// Tells joints with a spring that is too fast for substeps of h seconds, if nothing else held its bodies, or with
/// others.
bool any_stiff_spring(const Joint* joints, double h, const IslandProblem& problem);

}  // namespace atl::solver
