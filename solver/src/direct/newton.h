#pragma once

#include <solver/direct/balance_search.h>

namespace atl::solver {

/// Down the gradient, by the factor that there is, with what that changes at contacts and joints.
void find_direction(IslandProblem& problem, BalanceSearch& search);

/// Newton's method with an exact line search. Friction's bound follows the load in the first `follows` iterations.
/// Returns false where it ends nowhere.
bool minimise(IslandProblem& problem, BalanceSearch& search, int follows);

/// Brings friction's bounds up to the loads that came of them, at a solution, and solves again, until that changes
/// velocities by little, or in as many rounds as there are. The bounds are given while the balance is solved, as
/// friction were of no function else, and are not quite those of the loads at the end. Returns false where a round ends
/// nowhere.
bool settle_friction_bounds(IslandProblem& problem, BalanceSearch& search);

}  // namespace atl::solver
