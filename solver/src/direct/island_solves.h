#pragma once
/// The two ways in which an island is solved at once.

#include <solver/direct/island_members.h>
#include <solver/direct/island_motions.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <vector>

namespace atl::solver {

/// Contacts alone: one solve for the step as a whole. Returns false, with no state changed, where that ends nowhere.
bool solve_step(const SolveInput& input, const std::vector<MovingBody>& bodies, IslandMotions& motions);

/// Solves an island with joints in substeps of RATTLE (Andersen, "Rattle: a velocity version of the Shake algorithm",
/// J. Comput. Phys. 1983), with the contacts in the system of the joints. Returns false, with no state changed, if a
/// search doesn't converge or something may bounce.
bool solve_substeps(const SolveInput& input, const IslandMembers& members, std::vector<MovingBody>& bodies,
                    IslandMotions& motions);

}  // namespace atl::solver
