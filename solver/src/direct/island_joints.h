#pragma once
/// The joints of an island that is solved at once: their rows and laws, as bodies move.

#include <solver/direct/direct_island_input.h>
#include <solver/direct/island_members.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>

#include <vector>

namespace atl::solver {

/// Fills in the problem's joints, but for what follows their bodies. Returns whether all rows are locked: then none
/// goes to another piece of its law.
bool load_joints(const DirectIslandInput& input, const IslandMembers& members, std::vector<DirectJoint>& joints);

/// The law of a row, of which those of the point come first, which are locked.
const Law& law_of(const Joint& joint, std::size_t row);

/// Inertia and joints at the poses of now, `time` seconds into the step, in a substep of h seconds.
void place_joints(const DirectIslandInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandProblem& problem);

/// Whether a coordinate that bounces at the ends of its range may get there within the step, and not rest there.
bool may_bounce(const DirectIslandInput& input, const IslandProblem& problem);

/// The laws of rows over a substep of h seconds that starts at `velocities`.
void begin_laws(const Joint* joints, double h, const std::vector<double>& velocities, IslandProblem& problem);

/// After a solution: rows that are held go on, on which impulses of springs and motors act no more.
void hold_rows(const Joint* joints, IslandProblem& problem);

/// Notes the rates of armatures at these velocities.
void note_armature(const Joint* joints, const std::vector<double>& velocities, std::vector<DirectJoint>& all);

/// Takes on the force of the last impulses, of h seconds: at once where it grows, and smoothly where it falls. Returns
/// whether it is far from what bodies' inertia has of it.
bool follow_tension(IslandProblem& problem, double h);

/// Writes impulses, forces and what holds to the joints.
void write_back_joints(const DirectIslandInput& input, const std::vector<DirectJoint>& joints);

}  // namespace atl::solver
