// A way to the solution from anywhere, whatever number of points start or stop to push on it: a primal-dual interior
// point method (Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 1992).
//
// Each point's impulse p and gap s = u + b + p / k, of its separating speed u, bias b and stiffness k, are both kept
// positive, and p s is led to 0 over the same path for all. Friction goes along with its impulse over its speed as its
// stiffness, bound by what the points push at the time.

#include <solver/direct/balance_search.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/newton.h"

namespace atl::solver {
namespace {

using Interior = DirectContact::Interior;

void start_path(IslandProblem& problem) {
  for (DirectContact& contact : problem.contacts) {
    contact.motion = contact.motion_at(problem.velocity);
    Interior& in = contact.interior;
    for (int i = 0; i < contact.law.points; ++i) {
      const double parts = contact.law.speed(i, contact.motion) + contact.law.bias[i];
      in.gap[i] = std::max(parts, tuning::start_speed);
      in.impulse[i] = contact.mass[i] * std::max(-parts, tuning::start_speed);
    }
  }
}

// The mean of p s over the effective masses, of `product(contact, point)`.
template <typename Product>
double mean_product(const std::vector<DirectContact>& contacts, const Product& product) {
  double sum = 0;
  std::size_t points = 0;
  for (const DirectContact& contact : contacts) {
    for (int i = 0; i < contact.law.points; ++i) {
      sum += product(contact.interior, i) / contact.mass[i];
      ++points;
    }
  }
  return points > 0 ? sum / static_cast<double>(points) : 0;
}

// Takes the balance where the path stands. Returns the mean of p s.
double balance_on_path(IslandProblem& problem, std::vector<double>& gradient) {
  balance(problem, gradient, [](DirectContact& contact) {
    Interior& in = contact.interior;
    const ContactLaw& law = contact.law;
    double load = 0;
    for (int i = 0; i < law.points; ++i) load += in.impulse[i];
    contact.bound_friction(load);
    ContactAnswer answer = law.answer(contact.motion);
    for (int i = 0; i < law.points; ++i) {
      const double deflection = in.impulse[i] / law.stiffness[i];
      answer.normal[i] = in.impulse[i];
      in.missing[i] = law.speed(i, contact.motion) + law.bias[i] + deflection - in.gap[i];
      in.held[i] = in.impulse[i] / (in.gap[i] + deflection);
    }
    return answer;
  });
  return mean_product(problem.contacts, [](const Interior& in, int i) { return in.impulse[i] * in.gap[i]; });
}

// Finds the step to where p s is `target` times the effective mass; `corrected` for what the step that is there makes
// of their product. Returns how much of it can be taken.
double find_step(IslandProblem& problem, BalanceSearch& search, double target, bool corrected) {
  const auto wanted = [&](const DirectContact& contact, int i) {
    const Interior& in = contact.interior;
    const double product = in.impulse[i] * in.gap[i] + (corrected ? in.impulse_step[i] * in.gap_step[i] : 0);
    return target * contact.mass[i] - product;
  };
  const auto slack = [](const DirectContact& contact, int i) {
    return contact.interior.gap[i] + contact.interior.impulse[i] / contact.law.stiffness[i];
  };
  std::vector<double>& direction = search.direction;
  for (std::size_t i = 0; i < direction.size(); ++i) direction[i] = -search.gradient[i];
  for (const DirectContact& contact : problem.contacts) {
    const Interior& in = contact.interior;
    ContactAnswer pushes;
    for (int i = 0; i < contact.law.points; ++i) {
      pushes.normal[i] = (wanted(contact, i) - in.impulse[i] * in.missing[i]) / slack(contact, i);
    }
    contact.add_impulse(contact.law.total(pushes), 1, direction);
  }
  search.matrix.solve(direction);
  double reach = 1;
  for (DirectContact& contact : problem.contacts) {
    Interior& in = contact.interior;
    contact.change = contact.motion_by(direction);
    for (int i = 0; i < contact.law.points; ++i) {
      const double parts = contact.law.speed(i, contact.change) + in.missing[i];
      in.impulse_step[i] = (wanted(contact, i) - in.impulse[i] * parts) / slack(contact, i);
      in.gap_step[i] = parts + in.impulse_step[i] / contact.law.stiffness[i];
      if (in.impulse_step[i] < 0) reach = std::min(reach, -tuning::most_of_way * in.impulse[i] / in.impulse_step[i]);
      if (in.gap_step[i] < 0) reach = std::min(reach, -tuning::most_of_way * in.gap[i] / in.gap_step[i]);
    }
  }
  return reach;
}

// The mean of p s after so much of the step.
double mean_after(const IslandProblem& problem, double t) {
  return mean_product(problem.contacts, [t](const Interior& in, int i) {
    return (in.impulse[i] + t * in.impulse_step[i]) * (in.gap[i] + t * in.gap_step[i]);
  });
}

void take_step(IslandProblem& problem, const std::vector<double>& direction, double t) {
  for (std::size_t i = 0; i < direction.size(); ++i) problem.velocity[i] += t * direction[i];
  for (DirectContact& contact : problem.contacts) {
    Interior& in = contact.interior;
    for (int i = 0; i < contact.law.points; ++i) {
      in.impulse[i] += t * in.impulse_step[i];
      in.gap[i] += t * in.gap_step[i];
    }
  }
}

// The points that push at the path's end.
void take_pieces(std::vector<DirectContact>& contacts) {
  for (DirectContact& contact : contacts) {
    const Interior& in = contact.interior;
    contact.answer.pieces.points = 0;
    for (int i = 0; i < contact.law.points; ++i) {
      if (in.impulse[i] > in.gap[i] * contact.law.stiffness[i]) {
        contact.answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
      }
    }
  }
}

bool follow_path(IslandProblem& problem, BalanceSearch& search) {
  start_path(problem);
  for (int step = 0; step < tuning::most_interior_steps; ++step) {
    const double mean = balance_on_path(problem, search.gradient);
    const double residual = unbalanced(problem, search.gradient);
    if (mean <= tuning::near_end) {
      if (residual <= tuning::balance_tolerance) return true;
      // Friction lags behind, but it is known which points push.
      take_pieces(problem.contacts);
      return solve_on_last_pieces(problem, search) && minimise(problem, search, tuning::following);
    }
    if (!std::isfinite(mean + residual)) return false;
    ++search.iterations;
    if (!search.matrix.factor_on_interior_path(problem)) return false;
    // How far it could go at once says how far it should.
    const double reach = find_step(problem, search, 0, false);
    const double shrinks = mean_after(problem, reach) / mean;
    take_step(problem, search.direction, find_step(problem, search, shrinks * shrinks * shrinks * mean, true));
  }
  return false;
}

}  // namespace

bool solve_by_interior_point(IslandProblem& problem, BalanceSearch& search) {
  return follow_path(problem, search) && settle_friction_bounds(problem, search);
}

}  // namespace atl::solver
