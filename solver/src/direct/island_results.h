#pragma once
/// Hands the contact impulses of an island that was solved at once to manifolds, load reports and the error audit.

#include <solver/direct/island_problem.h>
#include <solver/direct/solve_input.h>

namespace atl::solver {

/// Writes the impulses of contacts to their manifolds. `share`: what a substep has of those that were solved for.
void write_back_contacts(const SolveInput& input, double share, const std::vector<DirectContact>& contacts);

/// Adds what contacts have pushed to SolveInput::pushed; the first of a step forgets what an attempt before it noted.
void record_pushes(const IslandProblem& problem, bool first, float* pushed);

/// Hands on what was solved over `step` seconds, and the answer, to the audit.
void capture_contacts(ContactCapture& capture, const collision::ContactManifold* manifolds, double step,
                      const IslandProblem& problem);

}  // namespace atl::solver
