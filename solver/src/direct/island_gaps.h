#pragma once
/// Finds and closes the gaps of joints of an island that is solved at once.

#include <solver/direct/island_motions.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <span>
#include <vector>

namespace atl::solver {

/// Closes what bodies' turns in a substep of h seconds have left open, `time` seconds into the step, in their poses and
/// in the velocities that they keep, unless these make energy.
void close_joints(const SolveInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandMotions& motions);

/// Closes what that has left, in poses, at the end of the step. Returns whether that was as little as it should be.
bool settle_joints(const SolveInput& input, std::vector<MovingBody>& bodies, IslandMotions& motions);

}  // namespace atl::solver
