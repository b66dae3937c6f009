#include <solver/direct/island_problem.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace atl::solver {

void IslandProblem::resize(std::size_t body_count) {
  bodies.resize(body_count);
  for (auto* numbers : {&velocity, &free, &gradient_, &direction_, &product_}) numbers->resize(6 * body_count);
}

bool IslandProblem::solve() { return solve_on_last_pieces() && minimise(tuning::following) && settle_friction(); }

bool IslandProblem::solve_by_interior() { return follow_interior() && settle_friction(); }

// Friction's bound was given, and is not quite that of the load which came of it. Where the load goes to and fro with
// the bound, the mean of both takes it home.
bool IslandProblem::settle_friction() {
  double before = std::numeric_limits<double>::infinity();
  for (int round = 0;; ++round) {
    const double off = friction_off();
    if (off <= tuning::friction_tolerance) return true;
    if (round == tuning::friction_rounds) return !joints.empty();
    const double share = off < 0.5 * before ? 1 : 0.5;
    before = off;
    for (DirectContact& contact : contacts) {
      contact.bound_friction(contact.bound_load + share * (contact.answer.load() - contact.bound_load));
    }
    if (!minimise(0)) return false;
  }
}

// m/s: how much too fast or slow friction makes something, by its bounds.
double IslandProblem::friction_off() const {
  double most = 0;
  for (const DirectContact& contact : contacts) {
    const ContactAnswer& answer = contact.answer;
    // What is not at its bound asks for this load at least.
    double asks = answer.load();
    const auto ask = [&](double impulse, double of_load) {
      if (of_load > 0) asks = std::max(asks, std::abs(impulse) / of_load);
    };
    if (answer.pieces.slides || answer.pieces.spins || answer.pieces.rolls) asks = contact.bound_load;
    const double pull = contact.law.pyramid ? std::max(std::abs(answer.friction[0]), std::abs(answer.friction[1]))
                                            : std::hypot(answer.friction[0], answer.friction[1]);
    ask(pull, contact.friction);
    ask(answer.twist, contact.lever * contact.friction + contact.torsional);
    ask(std::hypot(answer.rolling[0], answer.rolling[1]), contact.rolling);
    const double off = std::abs(asks - answer.load());
    const auto of = [&](std::uint32_t body) {
      if (body == no_body) return 0.0;
      const double spin =
          (contact.lever * contact.friction + contact.torsional + contact.rolling) / bodies[body].radius;
      return off * std::max(contact.friction, spin) / bodies[body].mass;
    };
    most = std::max({most, of(contact.first), of(contact.second)});
  }
  return most;
}

// Opposite contacts that overlap can't both open, and may push each other as hard as they like.
bool IslandProblem::is_bounded(double from_outside) const {
  double all = from_outside;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Map<const Vector3> linear(&free[6 * i]);
    const Eigen::Map<const Vector3> angular(&free[6 * i + 3]);
    all += bodies[i].mass * (linear.norm() + bodies[i].radius * angular.norm());
  }
  for (const DirectContact& contact : contacts) {
    const double moved = std::hypot(contact.given[0], contact.given[3], contact.given[4]);
    if (contact.first != no_body) all += bodies[contact.first].mass * moved;
    if (contact.second != no_body) all += bodies[contact.second].mass * moved;
  }
  return std::all_of(contacts.begin(), contacts.end(),
                     [&](const DirectContact& contact) { return contact.answer.load() <= tuning::most_impulse * all; });
}

// The velocities if all contacts stay on the pieces that they are on.
bool IslandProblem::solve_on_last_pieces() {
  balance([](const DirectContact& contact) {
    return contact.law.linear_answer(contact.motion, contact.answer.pieces, contact.answer);
  });
  if (!is_factored() && !factor()) return false;
  find_direction();
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += direction_[i];
  follow_load(1);
  return true;
}

bool IslandProblem::minimise(int follows) {
  for (int iteration = 0;; ++iteration) {
    balance([](const DirectContact& contact) { return contact.law.answer(contact.motion); });
    const double residual = unbalanced();
    if (residual <= tuning::balance_tolerance) return true;
    if (iteration == (joints.empty() ? tuning::most_iterations : tuning::most_iterations_of_joints) ||
        !std::isfinite(residual))
      return false;
    ++iterations_;
    if (!is_factored() && !factor()) return false;
    find_direction();
    mass_times(direction_, product_);
    mass_slope_ = mass_curvature_ = 0;
    for (std::size_t i = 0; i < direction_.size(); ++i) {
      mass_slope_ += (velocity[i] - free[i]) * product_[i];
      mass_curvature_ += direction_[i] * product_[i];
    }
    const double t = step_length();
    for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += t * direction_[i];
    if (iteration < follows) follow_load(t);
  }
}

// Down the gradient, by the factor that there is.
void IslandProblem::find_direction() {
  for (std::size_t i = 0; i < gradient_.size(); ++i) direction_[i] = -gradient_[i];
  system_.solve(direction_);
  for (DirectContact& contact : contacts) contact.change = motion_of(contact, direction_);
  for (DirectJoint& joint : joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) joint.change[r] = rate_of(joint, r, direction_);
  }
}

// The largest part of a body's velocity that the impulses on it don't account for.
double IslandProblem::unbalanced() const {
  double most = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Map<const Vector3> linear(&gradient_[6 * i]);
    const Eigen::Map<const Vector3> angular(&gradient_[6 * i + 3]);
    const double off = linear.norm() / bodies[i].mass + bodies[i].radius * (bodies[i].inverse_inertia * angular).norm();
    if (!(off <= most)) most = off;  // also where it is no number
  }
  return most;
}

// The bound of friction becomes that of the load a way along the search direction.
void IslandProblem::follow_load(double t) {
  for (DirectContact& contact : contacts) {
    contact.bound_friction(contact.law.answer(contact.motion_after(t)).load());
  }
}

// Of the function along the search direction.
double IslandProblem::slope(double t) const {
  double sum = mass_slope_ + t * mass_curvature_;
  for (const DirectContact& contact : contacts) {
    const Six impulse = contact.law.total(contact.law.answer(contact.motion_after(t)));
    for (int k = 0; k < 6; ++k) sum -= impulse[k] * contact.change[k];
  }
  for (const DirectJoint& joint : joints) {
    for (std::size_t r = 0; r < joint.rows; ++r) {
      sum -= joint.law[r].impulse(joint.rate[r] + t * joint.change[r]) * joint.change[r];
    }
  }
  return sum;
}

// Where the slope vanishes, or all the way if it doesn't before. Regula falsi that halves what it keeps (Dowell and
// Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 1971).
double IslandProblem::step_length() const {
  constexpr double flat = 1e-3;  // of the slope at the start
  constexpr int rounds = 30;
  double low = 0;
  double high = 1;
  double slope_low = slope(0);
  double slope_high = slope(1);
  const double enough = flat * std::abs(slope_low);
  if (!(slope_low < 0) || !(slope_high > enough)) return 1;
  double t = 1;
  int kept = 0;  // how often the lower end was, if negative the upper
  for (int round = 0; round < rounds; ++round) {
    t = low + (high - low) * slope_low / (slope_low - slope_high);
    const double here = slope(t);
    if (std::abs(here) <= enough) break;
    if (here < 0) {
      low = t;
      slope_low = here;
      kept = std::min(kept, 0) - 1;
      if (kept < -1) slope_high *= 0.5;
    } else {
      high = t;
      slope_high = here;
      kept = std::max(kept, 0) + 1;
      if (kept > 1) slope_low *= 0.5;
    }
  }
  return t;
}

void IslandProblem::velocities_of_impulses(std::vector<double>& to) const {
  to = velocity;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    Eigen::Map<Vector3>(&to[6 * i]) -= Eigen::Map<const Vector3>(&gradient_[6 * i]) / bodies[i].mass;
    Eigen::Map<Vector3>(&to[6 * i + 3]) -= bodies[i].inverse_inertia * Eigen::Map<const Vector3>(&gradient_[6 * i + 3]);
  }
}

}  // namespace atl::solver
