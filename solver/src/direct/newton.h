#pragma once

#include <solver/direct/balance_search.h>

namespace atl::solver {

/// Down the gradient, by the factor that there is, with what that changes at contacts and joints.
void find_direction(IslandProblem& problem, BalanceSearch& search);

/// Newton's method with an exact line search. Friction's bound follows the load in the first `follows` iterations.
/// Returns false where it ends nowhere.
bool minimise(IslandProblem& problem, BalanceSearch& search, int follows);

}  // namespace atl::solver
