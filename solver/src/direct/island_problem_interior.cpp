// A way to the solution from anywhere, whatever number of points start or stop to push on it: a primal-dual interior
// point method (Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim. 1992).
//
// Each point's impulse p and gap s = u + b + p / k, of its separating speed u, bias b and stiffness k, are both kept
// positive, and p s is led to 0 over the same path for all. Friction goes along with its impulse over its speed as its
// stiffness, bound by what the points push at the time.

#include <solver/direct/island_problem.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
bool IslandProblem::follow_interior() {
  start_interior();
  for (int step = 0; step < tuning::most_interior_steps; ++step) {
    const double mean = note_interior();
    const double residual = unbalanced();
    if (mean <= tuning::near_end) {
      if (residual <= tuning::balance_tolerance) return true;
      // Friction lags behind, but it is known which points push.
      take_pieces();
      return solve_on_last_pieces() && minimise(tuning::following);
    }
    if (!std::isfinite(mean + residual)) return false;
    ++iterations_;
    if (!factor_interior()) return false;
    // How far it could go at once says how far it should.
    const double reach = interior_step(0, false);
    const double shrinks = interior_after(reach) / mean;
    take_interior_step(interior_step(shrinks * shrinks * shrinks * mean, true));
  }
  return false;
}

void IslandProblem::start_interior() {
  for (DirectContact& contact : contacts) {
    contact.motion = motion_of(contact);
    DirectContact::Interior& in = contact.interior;
    for (int i = 0; i < contact.law.points; ++i) {
      const double parts = contact.law.speed(i, contact.motion) + contact.law.bias[i];
      in.gap[i] = std::max(parts, tuning::start_speed);
      in.impulse[i] = contact.mass[i] * std::max(-parts, tuning::start_speed);
    }
  }
}

void IslandProblem::take_pieces() {
  for (DirectContact& contact : contacts) {
    const DirectContact::Interior& in = contact.interior;
    contact.answer.pieces.points = 0;
    for (int i = 0; i < contact.law.points; ++i) {
      if (in.impulse[i] > in.gap[i] * contact.law.stiffness[i]) {
        contact.answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
      }
    }
  }
}

// Where it stands. Returns the mean of p s over the effective masses.
double IslandProblem::note_interior() {
  double sum = 0;
  std::size_t points = 0;
  balance([&](DirectContact& contact) {
    DirectContact::Interior& in = contact.interior;
    const ContactLaw& law = contact.law;
    double load = 0;
    for (int i = 0; i < law.points; ++i) load += in.impulse[i];
    contact.bound_friction(load);
    ContactAnswer answer = law.answer(contact.motion);
    for (int i = 0; i < law.points; ++i) {
      const double give = in.impulse[i] / law.stiffness[i];
      answer.normal[i] = in.impulse[i];
      in.missing[i] = law.speed(i, contact.motion) + law.bias[i] + give - in.gap[i];
      in.held[i] = in.impulse[i] / (in.gap[i] + give);
      sum += in.impulse[i] * in.gap[i] / contact.mass[i];
      ++points;
    }
    return answer;
  });
  return points > 0 ? sum / static_cast<double>(points) : 0;
}

bool IslandProblem::factor_interior() {
  add_masses();
  for (DirectContact& contact : contacts) {
    add_stiffness(contact, contact.law.secant(contact.motion, contact.interior.held));
    contact.factored.points = 0xff;  // not that of any pieces
  }
  for (DirectJoint& joint : joints) add_stiffness(joint);
  return system_.factor();
}

// The step to where p s is `target` times the effective mass; `corrected` for what the step that is there makes of
// their product. Returns how much of it can be taken.
double IslandProblem::interior_step(double target, bool corrected) {
  const auto wanted = [&](const DirectContact& contact, int i) {
    const DirectContact::Interior& in = contact.interior;
    const double product = in.impulse[i] * in.gap[i] + (corrected ? in.impulse_step[i] * in.gap_step[i] : 0);
    return target * contact.mass[i] - product;
  };
  const auto slack = [](const DirectContact& contact, int i) {
    return contact.interior.gap[i] + contact.interior.impulse[i] / contact.law.stiffness[i];
  };
  for (std::size_t i = 0; i < gradient_.size(); ++i) direction_[i] = -gradient_[i];
  for (const DirectContact& contact : contacts) {
    const DirectContact::Interior& in = contact.interior;
    ContactAnswer pushes;
    for (int i = 0; i < contact.law.points; ++i) {
      pushes.normal[i] = (wanted(contact, i) - in.impulse[i] * in.missing[i]) / slack(contact, i);
    }
    add_impulse(contact, contact.law.total(pushes), 1, direction_);
  }
  system_.solve(direction_);
  double reach = 1;
  for (DirectContact& contact : contacts) {
    DirectContact::Interior& in = contact.interior;
    contact.change = motion_of(contact, direction_);
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
double IslandProblem::interior_after(double t) const {
  double sum = 0;
  std::size_t points = 0;
  for (const DirectContact& contact : contacts) {
    const DirectContact::Interior& in = contact.interior;
    for (int i = 0; i < contact.law.points; ++i) {
      sum += (in.impulse[i] + t * in.impulse_step[i]) * (in.gap[i] + t * in.gap_step[i]) / contact.mass[i];
      ++points;
    }
  }
  return points > 0 ? sum / static_cast<double>(points) : 0;
}

void IslandProblem::take_interior_step(double t) {
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += t * direction_[i];
  for (DirectContact& contact : contacts) {
    DirectContact::Interior& in = contact.interior;
    for (int i = 0; i < contact.law.points; ++i) {
      in.impulse[i] += t * in.impulse_step[i];
      in.gap[i] += t * in.gap_step[i];
    }
  }
}

}  // namespace atl::solver
