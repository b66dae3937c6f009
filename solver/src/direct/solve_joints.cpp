#include <jobs/assert.h>
#include <solver/direct/balance_search.h>
#include <solver/tuning.h>

namespace atl::solver {
namespace {

// m/s or rad/s: the rate at which a row that acts would have no impulse, on the piece of its law that it is on.
double balanced_rate(const RowLaw& law, double rate, double slope) { return rate + law.impulse(rate) / slope; }

// Finds the change of rate that each row asks for at the free velocities, and the impulses of the rows on a piece where
// the law's impulse is constant. Returns true if there is any of the latter that isn't zero.
bool ask(const IslandProblem& problem, std::vector<double>& rates, std::vector<double>& given) {
  bool any = false;
  double* asked = rates.data();
  double* done = given.data();
  for (const DirectJoint& joint : problem.joints) {
    joint.rates_by(problem.velocity.data(), asked);
    const std::size_t points = joint.point_rows();
    for (std::size_t r = 0; r < points; ++r) {
      asked[r] = joint.is_still(r) ? 0 : joint.law[r].lock_rate - asked[r] - joint.given[r];
    }
    asked += points;
    done += points;
    for (std::size_t r = points; r < joint.rows; ++r, ++asked, ++done) {
      const RowLaw& law = joint.law[r];
      if (law.locked) {
        *asked = law.lock_rate - *asked - joint.given[r];
        *done = 0;
        continue;
      }
      const double slope = law.slope(joint.rate[r]);
      *done = slope > 0 ? 0 : law.impulse(joint.rate[r]);
      any |= *done != 0;
      *asked = slope > 0 ? balanced_rate(law, joint.rate[r], slope) - *asked - joint.given[r] : 0;
    }
  }
  return any;
}

// Takes on the rates and impulses of a solution. Returns whether all rows are on the pieces that it was found on.
bool take_on(IslandProblem& problem, const std::vector<double>& impulses, const std::vector<double>& given) {
  bool stays = true;
  const double* found = impulses.data();
  const double* done = given.data();
  for (DirectJoint& joint : problem.joints) {
    const std::size_t points = joint.point_rows();
    for (std::size_t r = 0; r < points; ++r) joint.impulse[r] = found[r];
    found += points;
    done += points;
    for (std::size_t r = points; r < joint.rows; ++r, ++found, ++done) {
      const RowLaw& law = joint.law[r];
      joint.impulse[r] = *found + *done;
      if (law.locked) continue;
      const double before = joint.rate[r], slope = law.slope(before);
      joint.rate[r] = slope > 0 ? balanced_rate(law, before, slope) - *found / slope
                                : joint.rate_by(problem.velocity, r, joint.given[r]);
      const int bound = law.motor_bound(before), bound_now = law.motor_bound(joint.rate[r]);
      const int rubs = law.friction_bound(before), rubs_now = law.friction_bound(joint.rate[r]);
      stays &= bound == bound_now && rubs == rubs_now && law.limit(before) == law.limit(joint.rate[r]);
      // Between pulling one way with all it has and the other, a motor is at its speed, and what rubs sticks.
      if (bound * bound_now < 0) joint.rate[r] = law.motor_speed;
      if (rubs * rubs_now < 0) joint.rate[r] = law.friction_speed;
    }
  }
  ATL_ASSERT(found == impulses.data() + impulses.size() && done == given.data() + given.size(), impulses.size(),
             given.size());
  return stays;
}

}  // namespace

bool solve_joints(IslandProblem& problem, BalanceSearch& search) {
  const JointResponse& response = *search.matrix.joints();
  std::vector<double>& impulses = search.impulses;
  std::vector<double>& given = search.given;
  impulses.resize(response.rows());
  given.resize(response.rows());  // entries of points stay 0
  for (int round = 0; round < tuning::mode_rounds; ++round) {
    if (!is_factored(problem) && !search.matrix.factor(problem)) return false;
    problem.velocity = problem.free;
    if (ask(problem, impulses, given)) {
      response.add_answer(problem, given, problem.velocity);
      ask(problem, impulses, given);
    }
    response.impulses_of(impulses);
    response.add_answer(problem, impulses, problem.velocity);
    if (take_on(problem, impulses, given)) return true;
    ++search.iterations;
  }
  return false;
}

}  // namespace atl::solver
