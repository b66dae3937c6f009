#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "direct/newton.h"

namespace atl::solver {
namespace {

// N s: the load of which friction is what it is; what is not at its bound asks for this load at least.
double load_asked_for(const DirectContact& contact) {
  const ContactAnswer& answer = contact.answer;
  double asks = answer.load();
  const auto ask = [&](double impulse, double of_load) {
    if (of_load > 0) asks = std::max(asks, std::abs(impulse) / of_load);
  };
  if (answer.pieces.slides || answer.pieces.spins || answer.pieces.rolls) asks = contact.bound_load;
  const double pull = contact.law.pyramid ? std::max(std::abs(answer.friction[0]), std::abs(answer.friction[1]))
                                          : std::hypot(answer.friction[0], answer.friction[1]);
  ask(pull, contact.friction);
  ask(answer.torsional, contact.radius * contact.friction + contact.torsional);
  ask(std::hypot(answer.rolling[0], answer.rolling[1]), contact.rolling);
  return asks;
}

// m/s: how much too fast or slow friction makes something, by its bounds.
double friction_error(const IslandProblem& problem) {
  double most = 0;
  for (const DirectContact& contact : problem.contacts) {
    const double off = std::abs(load_asked_for(contact) - contact.answer.load());
    const auto of = [&](std::uint32_t body) {
      if (body == no_body) return 0.0;
      const double spin =
          (contact.radius * contact.friction + contact.torsional + contact.rolling) / problem.bodies[body].radius;
      return off * std::max(contact.friction, spin) / problem.bodies[body].mass;
    };
    most = std::max({most, of(contact.first), of(contact.second)});
  }
  return most;
}

}  // namespace

// Where the load goes to and fro with the bound, the mean of both takes it home.
bool settle_friction_bounds(IslandProblem& problem, BalanceSearch& search) {
  double before = std::numeric_limits<double>::infinity();
  for (int round = 0;; ++round) {
    const double error = friction_error(problem);
    if (error <= tuning::friction_tolerance || round == tuning::friction_rounds) return true;
    const double share = error < 0.5 * before ? 1 : 0.5;
    before = error;
    for (DirectContact& contact : problem.contacts) {
      contact.bound_friction(contact.bound_load + share * (contact.answer.load() - contact.bound_load));
    }
    if (!minimise(problem, search, 0)) return false;
  }
}

}  // namespace atl::solver
