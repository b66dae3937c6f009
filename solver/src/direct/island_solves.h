#pragma once
/// The two ways in which an island is solved at once, and the parts of a solve that both have.

#include <solver/direct/island_members.h>
#include <solver/direct/island_motions.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/moving_bodies.h>
#include <solver/direct/solve_input.h>

#include <vector>

namespace atl::solver {

/// Contacts alone, for the step as a whole: one solve, and where bodies turn far others, each with the turn that the
/// last one tells. Returns false, with no state changed, where one ends nowhere.
bool solve_step(const SolveInput& input, const IslandMembers& members, const std::vector<MovingBody>& bodies,
                IslandMotions& motions);

/// Solves an island with joints in substeps of RATTLE (Andersen, "Rattle: a velocity version of the Shake algorithm",
/// J. Comput. Phys. 1983), with the contacts in the system of the joints. Returns false, with no state changed, if a
/// search doesn't converge or something may bounce.
bool solve_substeps(const SolveInput& input, const IslandMembers& members, std::vector<MovingBody>& bodies,
                    IslandMotions& motions);

// Results of an island that was solved at once, handed on to manifolds, load reports and the error audit.

/// Writes the impulses of contacts to their manifolds. `share`: what a substep has of those that were solved for.
void write_back_contacts(const SolveInput& input, double share, const std::vector<DirectContact>& contacts);

/// Adds what contacts have pushed to SolveInput::pushed; the first of a step forgets what an attempt before it noted.
void record_pushes(const IslandProblem& problem, bool first, float* pushed);

/// Hands on what was solved over `step` seconds, and the answer, to the audit.
void capture_contacts(ContactCapture& capture, const collision::ContactManifold* manifolds, double step,
                      const IslandProblem& problem);

// Gaps of joints.

/// Closes what bodies' turns in a substep of h seconds have left open, `time` seconds into the step, in their poses and
/// in the velocities that they keep, unless these make energy.
void close_joints(const SolveInput& input, double time, double h, std::vector<MovingBody>& bodies,
                  IslandMotions& motions);

/// Closes what that has left, in poses, at the end of the step. Returns whether that was as little as it should be.
bool settle_joints(const SolveInput& input, std::vector<MovingBody>& bodies, IslandMotions& motions);

// Contacts, loaded from manifolds, and placed as bodies move.

/// Fills in the problem's contacts, for its bodies and their velocities. Returns false if one bounces: that wants the
/// impact's speed.
bool load_contacts(const SolveInput& input, const IslandMembers& members, IslandProblem& problem);

/// Places contacts where they are half way through the step by the turns of the problem's bodies.
void turn_contacts(const SolveInput& input, const IslandMembers& members, IslandProblem& problem);

/// Separations at these poses. As sweeps see them: a contact stays where it was on its bodies as the step began, but
/// where they roll, and its normal stays too.
void place_contacts(const IslandPoses& poses, std::vector<DirectContact>& contacts);

}  // namespace atl::solver
