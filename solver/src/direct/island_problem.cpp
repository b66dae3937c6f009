#include <solver/direct/island_problem.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {

double unbalanced(const IslandProblem& problem, const std::vector<double>& gradient) {
  double max = 0;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const DirectBody& body = problem.bodies[i];
    const auto linear = linear_part(gradient, i);
    const auto angular = angular_part(gradient, i);
    const double off = linear.norm() / body.mass + body.radius * (body.inverse_inertia * angular).norm();
    if (!(off <= max)) max = off;  // also where it is no number
  }
  return max;
}

bool is_bounded(const IslandProblem& problem, double from_outside) {
  const std::vector<DirectBody>& bodies = problem.bodies;
  double all = from_outside;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto linear = linear_part(problem.free, i);
    const auto angular = angular_part(problem.free, i);
    all += bodies[i].mass * (linear.norm() + bodies[i].radius * angular.norm());
  }
  for (const DirectContact& contact : problem.contacts) {
    const double moved = std::hypot(contact.given[0], contact.given[3], contact.given[4]);
    if (contact.first != no_body) all += bodies[contact.first].mass * moved;
    if (contact.second != no_body) all += bodies[contact.second].mass * moved;
  }
  return std::all_of(problem.contacts.begin(), problem.contacts.end(),
                     [&](const DirectContact& contact) { return contact.answer.load() <= tuning::max_impulse * all; });
}

void velocities_of_impulses(const IslandProblem& problem, const std::vector<double>& gradient,
                            std::vector<double>& to) {
  to = problem.velocity;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const DirectBody& body = problem.bodies[i];
    linear_part(to, i) -= linear_part(gradient, i) / body.mass;
    angular_part(to, i) -= body.inverse_inertia * angular_part(gradient, i);
  }
}

}  // namespace atl::solver
