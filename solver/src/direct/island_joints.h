#pragma once
/// The joints of an island that is solved at once: their rows and laws, as bodies move.

#include <solver/direct/balance_search.h>
#include <solver/direct/island_members.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <vector>

namespace atl::solver {

/// Fills in the problem's joints, but for what follows their bodies.
RowKinds load_joints(const Joint* all, const IslandMembers& members, std::vector<DirectJoint>& joints);

/// A term of a tendon at these poses, its coordinate's position before given.
TermRow term_at(const Joint* joints, const DirectJoint& tendon, std::size_t i, const IslandPoses& poses, double before);

/// The law of a row, of which those of the point come first, which are locked.
const Law& law_of(const Joint& joint, std::size_t row);

/// Inertia and joints at the poses of now, `time` seconds into the step, in a substep of h seconds.
void place_joints(const SolveInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandProblem& problem);

/// Sets the compliance of locked rows, by their effective masses, once these are known. A matrix of joints alone takes
/// it from its diagonal.
void weigh_locks(const Joint* joints, IslandProblem& problem);

/// Makes the values of rows that nothing moves along zero.
void forget_still(const DirectJoint& joint, DirectJoint::Rows<double>& values);

/// The rates of a joint's rows at `velocities`, of what doesn't respond too.
void find_rates(const std::vector<double>& velocities, const DirectJoint& joint, DirectJoint::Rows<double>& rates);
/// Notes these of all joints, as those before a solution.
void record_rates(const std::vector<double>& velocities, std::vector<DirectJoint>& all);

/// The laws of rows over a substep of h seconds that starts at the rates that were noted.
void begin_laws(const Joint* joints, double h, IslandProblem& problem);

/// A row that was at an end of its range is taken to be there still.
void start_at_limit(DirectJoint& joint, std::size_t row);

/// The number of coordinates at ends of their ranges.
int count_rows_at_ends(const std::vector<DirectJoint>& all);

/// Coordinates that are beyond their ranges are to go no farther, by the velocities that bodies keep. Notes at what
/// rates they go back by the velocities that bodies move by, as overlapping shapes do: a speed that brought them back
/// would be energy that nothing has given.
void stop_at_ends(std::vector<DirectJoint>& all);
/// Tells if some coordinate was found to.
bool any_goes_back(const std::vector<DirectJoint>& all);
/// Ahead of the solution for the velocities that bodies move by; and once they have moved and joints are closed, by the
/// same factor: rows are then on the pieces of their laws, and at the rates, of the velocities that bodies keep.
void begin_going_back(std::vector<DirectJoint>& all);
void end_going_back(std::vector<DirectJoint>& all);

/// Finds by how much springs slow coordinates down that come to their ends: from a solution with ranges left out, while
/// they are, and by a solve for each of these coordinates.
void find_falls(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search);
/// Finds how fast they come there, from the same solution.
void record_impacts(const Joint* joints, double h, std::vector<DirectJoint>& all);

/// Locks rows that are held after a solution, so that springs and motors no longer act on them. A coordinate that
/// bounces leaves the end of its range, with velocities that are half a substep behind positions.
void hold_rows(const Joint* joints, IslandProblem& problem);

/// Notes the rates of armatures at these velocities.
void record_armature_rates(const Joint* joints, const std::vector<double>& velocities, std::vector<DirectJoint>& all);

/// Takes on the force of the last impulses, of h seconds, smoothly.
void follow_tension(IslandProblem& problem, double h);

/// Writes impulses, forces and what holds to the joints.
void write_back_joints(const SolveInput& input, const std::vector<DirectJoint>& joints);

}  // namespace atl::solver
