#pragma once

#include <solver/direct/balance_search.h>

namespace atl::solver {

/// Down the gradient, by the factor that there is, with what that changes at contacts and joints.
void find_direction(IslandProblem& problem, BalanceSearch& search);

/// Does balance() with all rows on the pieces of their laws that they are on.
void balance_on_last_pieces(IslandProblem& problem, std::vector<double>& gradient);

}  // namespace atl::solver
