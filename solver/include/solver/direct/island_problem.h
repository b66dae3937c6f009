#pragma once

#include <jobs/arrays.h>
#include <solver/direct/direct_rows.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <span>
#include <vector>

namespace atl::solver {

/// The velocities of an island's bodies at which its contacts and joints are in balance, in one system.
///
/// Contacts and joints are very slightly soft, so impulses are functions of the velocities v (ContactLaw, RowLaw), and
/// these are where a convex function is least:
///
///   |v - v*|^2_M / 2 + sum over contacts and joints of psi(J v),
///
/// with v* the velocities without them and -psi' their impulses (Todorov, "Convex and analytically-invertible dynamics
/// with contacts and constraints", ICRA 2014; Castro, Permenter and Han, "An unconstrained convex formulation of
/// compliant contact", T-RO 2022). Friction's bound is given while that is solved (see solve_by_newton()).
struct IslandProblem {
  std::vector<DirectBody> bodies;
  std::vector<DirectContact> contacts;
  std::vector<DirectJoint> joints;
  std::vector<double> velocity;  ///< six numbers a body, linear and angular, m/s and rad/s: v
  std::vector<double> free;      ///< the same for v*, the free velocities
  double lock_compliance = 0;    ///< of an effective mass's inverse, that locks and ends of ranges give
  bool filled = false;           ///< the matrix knows the rows of joints, and bodies, as they are placed
  bool factored = false;         ///< there is a factor, of the pieces that contacts and joints note

  /// Makes room for bodies.
  void resize(std::size_t body_count) {
    bodies.resize(body_count);
    velocity.resize(6 * body_count);
    free.resize(6 * body_count);
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(bodies, contacts, joints, velocity, free); }
};

/// Tells bodies that motion locks hold, as other joints would.
inline bool has_locks(const IslandProblem& problem) {
  return std::any_of(problem.bodies.begin(), problem.bodies.end(),
                     [](const DirectBody& body) { return body.locks != 0; });
}

/// Leaves out of six numbers a body those along and about the axes that it is locked on.
inline void leave_out_locked(const std::vector<DirectBody>& bodies, std::span<double> values) {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (unsigned rest = bodies[i].locks; rest != 0; rest &= rest - 1) {
      values[6 * i + static_cast<std::size_t>(std::countr_zero(rest))] = 0;
    }
  }
}

/// Takes the motions of contacts and the rates of joints at the problem's velocities, with the impulses that these
/// answer with, contacts by `answer(contact)` and rows of joints by `push(joint, row, rate)`. Makes `gradient` that of
/// the function, N s and N m s: what of M (v - v*) the impulses leave.
template <typename Answer, typename Push>
void balance(IslandProblem& problem, std::vector<double>& gradient, const Answer& answer, const Push& push) {
  const std::vector<double>& velocity = problem.velocity;
  for (std::size_t i = 0; i < velocity.size(); ++i) gradient[i] = velocity[i] - problem.free[i];
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const std::array<double, 6> momentum = problem.bodies[i].momentum(&gradient[6 * i]);
    for (std::size_t k = 0; k < 6; ++k) gradient[6 * i + k] = momentum[k];
  }
  for (DirectContact& contact : problem.contacts) {
    contact.motion = contact.motion_at(velocity);
    contact.answer = answer(contact);
    contact.add_impulse(contact.law.total(contact.answer), -1, gradient);
  }
  for (DirectJoint& joint : problem.joints) {
    DirectJoint::Rows<double> rates, against;
    joint.rates_by(velocity.data(), rates.data());
    for (std::size_t r = 0; r < joint.rows; ++r) {
      joint.impulse[r] = push(joint, r, rates[r] + joint.given[r]);
      against[r] = -joint.impulse[r];
    }
    joint.add_impulses(against.data(), gradient.data());
  }
  leave_out_locked(problem.bodies, gradient);
}

/// m/s: the largest part of a body's velocity that the impulses on it don't account for.
double unbalanced(const IslandProblem& problem, const std::vector<double>& gradient);

/// True if no contact pushes ten times as hard as would stop the whole island. Opposite contacts that overlap can't
/// both open, and their forces on each other then have no bound. `from_outside` (N s) is the impulse that drives and
/// carries the island beside its own momentum.
bool is_bounded(const IslandProblem& problem, double from_outside);

/// The velocities that the impulses make, so that no momentum is made up.
void velocities_of_impulses(const IslandProblem& problem, const std::vector<double>& gradient, std::vector<double>& to);

}  // namespace atl::solver
