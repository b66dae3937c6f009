#include <jobs/assert.h>
#include <solver/direct/balance_search.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

// The function of a problem along a search direction.
class AlongDirection {
 public:
  AlongDirection(const IslandProblem& problem, const std::vector<double>& direction) : problem_(problem) {
    for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
      const std::array<double, 6> momentum = problem.bodies[i].momentum(&direction[6 * i]);
      for (std::size_t k = 0; k < 6; ++k) {
        linear_slope_ += (problem.velocity[6 * i + k] - problem.free[6 * i + k]) * momentum[k];
        curvature_ += direction[6 * i + k] * momentum[k];
      }
    }
    for (const DirectJoint& joint : problem.joints) {
      for (std::size_t r = 0; r < joint.rows; ++r) {
        if (!joint.law[r].locked) continue;
        linear_slope_ -= joint.impulse[r] * joint.change[r];
        curvature_ += joint.law[r].stiffness * joint.change[r] * joint.change[r];
      }
    }
  }

  bool has_joints() const { return !problem_.joints.empty(); }
  double slope(double t) const {
    double sum = linear_slope_ + t * curvature_;
    for (const DirectContact& contact : problem_.contacts) {
      const Six impulse = contact.law.total(contact.law.answer(contact.motion_after(t)));
      for (int k = 0; k < 6; ++k) sum -= impulse[k] * contact.change[k];
    }
    for (const DirectJoint& joint : problem_.joints) {
      for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
        if (joint.law[r].locked) continue;
        sum -= joint.law[r].impulse(joint.rate[r] + t * joint.change[r]) * joint.change[r];
      }
    }
    return sum;
  }

 private:
  const IslandProblem& problem_;
  double linear_slope_ = 0, curvature_ = 0;  // of the first term, and of locks
};

// The step length at which the slope vanishes, or 1 if it doesn't before. Regula falsi that halves the kept slope
// (Dowell and Jarratt, "A modified regula falsi method for computing the root of an equation", BIT 1971).
double step_length(const AlongDirection& function) {
  constexpr double flat = 1e-3;  // of the slope at the start
  // Friction in a joint sticks only at rates below 1e-8 of the others, a narrow kink that the search has to hit.
  const int rounds = function.has_joints() ? 80 : 30;
  double low = 0;
  double high = 1;
  double slope_low = function.slope(0);
  double slope_high = function.slope(1);
  const double enough = flat * std::abs(slope_low);
  if (!(slope_low < 0) || !(slope_high > enough)) return 1;
  double t = 1;
  int kept = 0;  // how often the lower end was, if negative the upper
  for (int round = 0; round < rounds; ++round) {
    t = low + (high - low) * slope_low / (slope_low - slope_high);
    const double here = function.slope(t);
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
  ATL_ASSERT(!(t < 0) && !(t > 1), t, slope_low, slope_high);
  return t;
}

void go_along(const std::vector<double>& direction, double t, std::vector<double>& velocity) {
  for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] += t * direction[i];
}

// The bound of friction becomes that of the load a way along the search direction.
void follow_load(std::vector<DirectContact>& contacts, double t) {
  for (DirectContact& contact : contacts) {
    contact.bound_friction(contact.law.answer(contact.motion_after(t)).load());
  }
}

// Goes down the gradient as far as is best. Returns how much of the way to the minimum of the pieces that is, or 0 if
// there is no factor.
double descend(IslandProblem& problem, BalanceSearch& search) {
  if (!is_factored(problem) && !search.matrix.factor(problem)) return 0;
  find_direction(problem, search);
  const double t = step_length(AlongDirection(problem, search.direction));
  go_along(search.direction, t, problem.velocity);
  return t;
}

double push_by_law(DirectJoint& joint, std::size_t row, double rate) {
  joint.rate[row] = rate;
  return joint.law[row].impulse(rate);
}

// The impulse on the piece of the law that the joint has recorded, which stays.
double push_on_last_piece(DirectJoint& joint, std::size_t row, double rate) {
  const RowLaw& law = joint.law[row];
  if (law.locked) return push_by_law(joint, row, rate);
  return law.impulse(joint.rate[row]) - law.slope(joint.rate[row]) * (rate - joint.rate[row]);
}

void balance_by_laws(IslandProblem& problem, std::vector<double>& gradient) {
  const auto answer = [](const DirectContact& contact) { return contact.law.answer(contact.motion); };
  balance(problem, gradient, answer, push_by_law);
}

// Newton's method with an exact line search. Friction's bound follows the load in the first `follows` iterations.
// Returns false where it ends nowhere.
bool minimise(IslandProblem& problem, BalanceSearch& search, int follows) {
  for (int iteration = 0;; ++iteration) {
    balance_by_laws(problem, search.gradient);
    const double residual = unbalanced(problem, search.gradient);
    if (residual <= tuning::balance_tolerance) return true;
    if (iteration == search.max_iterations || !std::isfinite(residual)) return false;
    ++search.iterations;
    const double t = descend(problem, search);
    if (!(t > 0)) return false;
    if (iteration < follows) follow_load(problem.contacts, t);
  }
}

// N s, that a contact's own load bounds friction to.
double rubs_most(const DirectContact& contact) { return contact.friction * contact.answer.load(); }

// Tells a contact that sticks by no more than that, or slides by just as much, but for a tolerance (N s).
bool rubs_as_loaded(const DirectContact& contact, double tolerance) {
  const double most = rubs_most(contact);
  const double f1 = contact.answer.friction[0], f2 = contact.answer.friction[1] / contact.law.friction_ratio;
  const double rubs = contact.law.pyramid ? std::max(std::abs(f1), std::abs(f2)) : std::hypot(f1, f2);
  if (rubs > most + tolerance) return false;
  return contact.answer.pieces.slides == 0 || contact.law.friction_bound >= most - tolerance;
}

// Tells if friction of all contacts goes by their own loads, but for a part of the largest there is.
bool rub_as_loaded(const std::vector<DirectContact>& contacts) {
  double largest = 0;
  for (const DirectContact& contact : contacts) largest = std::max(largest, rubs_most(contact));
  const double tolerance = tuning::friction_tolerance * largest;
  return std::all_of(contacts.begin(), contacts.end(),
                     [&](const DirectContact& contact) { return rubs_as_loaded(contact, tolerance); });
}

bool go_to_end_of_last_pieces(IslandProblem& problem, BalanceSearch& search) {
  balance_on_last_pieces(problem, search.gradient);
  if (!is_factored(problem) && !search.matrix.factor(problem)) return false;
  find_direction(problem, search);
  go_along(search.direction, 1, problem.velocity);
  return true;
}

}  // namespace

void balance_on_last_pieces(IslandProblem& problem, std::vector<double>& gradient) {
  const auto answer = [](const DirectContact& contact) {
    return contact.law.linear_answer(contact.motion, contact.answer.pieces, contact.answer);
  };
  balance(problem, gradient, answer, push_on_last_piece);
}

// The bounds that a solution was found with may be those of loads that it hasn't: on its way a point that is a few um/s
// too deep pushes with a thousand times its load. Bounds follow, for some rounds, until no contact rubs by more or less
// than its own load tells.
bool solve_by_newton(IslandProblem& problem, BalanceSearch& search) {
  if (!solve_on_last_pieces(problem, search) || !minimise(problem, search, tuning::following)) return false;
  for (int round = 0; round < tuning::friction_rounds; ++round) {
    for (DirectContact& contact : problem.contacts) contact.bound_friction(contact.answer.load());
    if (!minimise(problem, search, round == 0 ? 1 : 0)) return false;
    if (rub_as_loaded(problem.contacts)) return true;
  }
  return true;
}

bool solve_on_last_pieces(IslandProblem& problem, BalanceSearch& search) {
  if (!go_to_end_of_last_pieces(problem, search)) return false;
  follow_load(problem.contacts, 1);
  return true;
}

bool solve_nearby(IslandProblem& problem, BalanceSearch& search) {
  return go_to_end_of_last_pieces(problem, search) && minimise(problem, search, 0);
}

bool step_by_newton(IslandProblem& problem, BalanceSearch& search) {
  balance_by_laws(problem, search.gradient);
  return descend(problem, search) > 0;
}

void find_direction(IslandProblem& problem, BalanceSearch& search) {
  std::vector<double>& direction = search.direction;
  ATL_ASSERT(direction.size() == 6 * problem.bodies.size() && search.gradient.size() == direction.size(),
             direction.size(), search.gradient.size(), problem.bodies.size());
  for (std::size_t i = 0; i < direction.size(); ++i) direction[i] = -search.gradient[i];
  search.matrix.solve(problem, direction);
  for (DirectContact& contact : problem.contacts) contact.change = contact.motion_by(direction);
  for (DirectJoint& joint : problem.joints) joint.rates_by(direction.data(), joint.change.data());
}

}  // namespace atl::solver
