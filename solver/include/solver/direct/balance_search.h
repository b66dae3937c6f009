#pragma once

#include <jobs/arrays.h>
#include <solver/direct/island_matrix.h>
#include <solver/direct/island_problem.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace atl::solver {

/// The working memory of a search for the velocities of an IslandProblem.
struct BalanceSearch {
  IslandMatrix matrix;
  std::vector<double> gradient;   ///< N s, N m s: of the function, see balance()
  std::vector<double> direction;  ///< m/s, rad/s: along which the velocities are to go
  std::vector<double> impulses;   ///< N s, N m s, of the rows of joints alone
  std::vector<double> given;      ///< the same for rows on a piece of their law where it is constant
  int max_iterations = 0;         ///< of Newton's method, in one search
  int iterations = 0;             ///< of Newton's method, beyond the first solves

  /// Makes room for as many bodies.
  void resize(std::size_t body_count) {
    gradient.resize(6 * body_count);
    direction.resize(6 * body_count);
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(matrix, gradient, direction, impulses, given); }
};

/// Solves by Newton's method, from the problem's velocities and the pieces that the answers are on. Friction's bound
/// follows the load. Returns false if it doesn't converge.
bool solve_by_newton(IslandProblem& problem, BalanceSearch& search);

/// Solves joints alone by their response: finds in a few rounds, from the rates that they note, which pieces of their
/// laws rows are on, with velocities and impulses. Returns false where these don't settle.
bool solve_joints(IslandProblem& problem, BalanceSearch& search);

/// Solves by Newton's method from velocities near the solution; friction's bounds stay.
bool solve_nearby(IslandProblem& problem, BalanceSearch& search);

/// One step of Newton's method with an exact line search; friction's bounds stay. Returns false if it ends nowhere.
bool step_by_newton(IslandProblem& problem, BalanceSearch& search);

/// Makes one linear solve, which is exact if all rows stay on the pieces that they are on.
bool solve_on_last_pieces(IslandProblem& problem, BalanceSearch& search);

/// Contacts and locks give by little under what they carry, but a column of many, or under many times its weight, would
/// sink on them. Solves once more, from the impulses that carry it already, as the method of multipliers does (Powell,
/// "A method for nonlinear constraints in minimization problems", 1969), for as long as something sinks. Points that
/// are apart may close what is open in dt seconds.
void take_back_compliance(IslandProblem& problem, BalanceSearch& search, double dt);

/// Makes the search's direction the motion that closes `gap(joint, row)` with the least work, and moves no contact that
/// holds. It is the factor's answer to the gaps, taken as rates.
template <typename Gap>
void find_closing_motion(const IslandProblem& problem, BalanceSearch& search, const Gap& gap) {
  std::fill(search.direction.begin(), search.direction.end(), 0.0);
  if (const JointResponse* response = search.matrix.joints()) {
    search.impulses.resize(response->rows());
    double* impulse = search.impulses.data();
    for (const DirectJoint& joint : problem.joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) *impulse++ = -gap(joint, r);
    }
    response->impulses_of(search.impulses);
    response->add_answer(problem, search.impulses, search.direction);
    return;
  }
  for (const DirectJoint& joint : problem.joints) {
    DirectJoint::Rows<double> impulses;
    for (std::size_t r = 0; r < joint.rows; ++r) impulses[r] = -gap(joint, r) * joint.law[r].slope(joint.rate[r]);
    joint.add_impulses(impulses.data(), search.direction.data());
  }
  search.matrix.solve(problem, search.direction);
}

/// Down the gradient, by the factor that there is, with what that changes at contacts and joints.
void find_direction(IslandProblem& problem, BalanceSearch& search);

/// Does balance() with all rows on the pieces of their laws that they are on.
void balance_on_last_pieces(IslandProblem& problem, std::vector<double>& gradient);

}  // namespace atl::solver
