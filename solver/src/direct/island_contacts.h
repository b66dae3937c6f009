#pragma once
/// The contacts of an island that is solved at once: loaded from manifolds, and placed as bodies move.

#include <solver/direct/island_members.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

namespace atl::solver {

/// Fills in the problem's contacts, for its bodies and their velocities. Returns false if one bounces: that wants the
/// impact's speed.
bool load_contacts(const SolveInput& input, const IslandMembers& members, IslandProblem& problem);

/// Separations at these poses. As sweeps see them: a contact stays where it was on its bodies as the step began, but
/// where they roll, and its normal stays too.
void place_contacts(const IslandPoses& poses, std::vector<DirectContact>& contacts);

}  // namespace atl::solver
