#include <solver/direct/island_problem.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {

double unbalanced(const IslandProblem& problem, const std::vector<double>& gradient) {
  double most = 0;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const DirectBody& body = problem.bodies[i];
    const Eigen::Map<const Vector3> linear(&gradient[6 * i]);
    const Eigen::Map<const Vector3> angular(&gradient[6 * i + 3]);
    const double off = linear.norm() / body.mass + body.radius * (body.inverse_inertia * angular).norm();
    if (!(off <= most)) most = off;  // also where it is no number
  }
  return most;
}

bool is_bounded(const IslandProblem& problem, double from_outside) {
  const std::vector<DirectBody>& bodies = problem.bodies;
  double all = from_outside;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Map<const Vector3> linear(&problem.free[6 * i]);
    const Eigen::Map<const Vector3> angular(&problem.free[6 * i + 3]);
    all += bodies[i].mass * (linear.norm() + bodies[i].radius * angular.norm());
  }
  for (const DirectContact& contact : problem.contacts) {
    const double moved = std::hypot(contact.given[0], contact.given[3], contact.given[4]);
    if (contact.first != no_body) all += bodies[contact.first].mass * moved;
    if (contact.second != no_body) all += bodies[contact.second].mass * moved;
  }
  return std::all_of(problem.contacts.begin(), problem.contacts.end(),
                     [&](const DirectContact& contact) { return contact.answer.load() <= tuning::most_impulse * all; });
}

void velocities_of_impulses(const IslandProblem& problem, const std::vector<double>& gradient,
                            std::vector<double>& to) {
  to = problem.velocity;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const DirectBody& body = problem.bodies[i];
    Eigen::Map<Vector3>(&to[6 * i]) -= Eigen::Map<const Vector3>(&gradient[6 * i]) / body.mass;
    Eigen::Map<Vector3>(&to[6 * i + 3]) -= body.inverse_inertia * Eigen::Map<const Vector3>(&gradient[6 * i + 3]);
  }
}

}  // namespace atl::solver
