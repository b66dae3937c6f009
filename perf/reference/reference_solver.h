#pragma once

#include <atoll/contact_problem.h>

#include <vector>

namespace atl::reference {

/// A contact problem with the impulses that solve it, and how they were found.
struct ReferenceSolution {
  ContactProblem problem;  ///< as given, with the impulses of the solution
  bool solved = false;     ///< the residual is within the tolerance
  double residual = 0;     ///< measure_contact_residual(problem).relative
  int newton_steps = 0;
  int sweeps = 0;
};

/// Solves a contact problem from the impulses that it comes with, by Gauss-Seidel to get near and by Newton's method
/// from there, until the relative residual is within the tolerance or a budget is used up. Meant for up to some hundred
/// patches. Where several sets of impulses solve the problem it is one of them; with friction, velocities may differ
/// too. Throws Error as measure_contact_residual does, and where there is more than plain friction.
ReferenceSolution solve_contact_problem(const ContactProblem& problem, double tolerance = 1e-10);

/// Velocity after the impulses of a problem, or before them.
struct BodyVelocity {
  Vector3 linear = Vector3::Zero();   ///< m/s
  Vector3 angular = Vector3::Zero();  ///< rad/s
};
std::vector<BodyVelocity> velocities_after(const ContactProblem& problem);
std::vector<BodyVelocity> free_velocities(const ContactProblem& problem);

/// sqrt((a - b)^T M (a - b)), the root of twice the kinetic energy of the difference: sqrt(J). Bodies of infinite mass
/// don't count.
double energy_distance(const ContactProblem& problem, const std::vector<BodyVelocity>& a,
                       const std::vector<BodyVelocity>& b);

/// How far the velocities that a problem's impulses lead to are from a solution's, relative to how much that changed
/// the free velocities: |v - v*|_M / |v* - v_free|_M. 0 if both are 0.
double velocity_error(const ContactProblem& problem, const ReferenceSolution& solution);

}  // namespace atl::reference
